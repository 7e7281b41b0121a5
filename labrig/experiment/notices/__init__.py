"""Inform others of a running session: hooks, and published documents."""
