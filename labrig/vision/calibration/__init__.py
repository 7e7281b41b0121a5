"""Calibrate a camera: lens, board, optics.json."""
