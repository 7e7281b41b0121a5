"""Curves from frame to frame, and where the rolls touch the sheet."""
