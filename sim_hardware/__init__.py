"""Simulated hardware, at the wire: NI boards, serial devices, a camera, and the sheet."""
