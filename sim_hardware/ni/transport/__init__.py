"""The server that the real nidaqmx package connects to."""
