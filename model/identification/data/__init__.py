"""The data vector: summary statistics of the readings, curves and pulses, acquisition times."""
