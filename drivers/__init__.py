"""Speak to one piece of hardware each; know nothing of protocols."""
