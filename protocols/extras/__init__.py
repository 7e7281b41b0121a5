"""Runs that a protocol may add to its measurements, a file each: keys of [extras]."""
