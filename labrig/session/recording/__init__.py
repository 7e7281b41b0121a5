"""Write a session while it is measured: rows, journal, queue, disk."""
