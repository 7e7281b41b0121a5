"""Verify a session file, and recover one whose writer was killed."""
