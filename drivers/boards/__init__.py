"""Boards with analog inputs and outputs."""
