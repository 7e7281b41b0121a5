"""Measurements kept in a session, as arrays that can be made again."""
