"""Positioners that move the load cell along the arc."""
