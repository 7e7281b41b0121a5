"""Simulated tasks, their channels, events and reservations."""
