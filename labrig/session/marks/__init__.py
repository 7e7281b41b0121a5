"""Marks after the end: runs and readings of a closed session that are declared invalid."""
