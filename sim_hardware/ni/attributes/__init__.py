"""Attributes of devices, channels and tasks."""
