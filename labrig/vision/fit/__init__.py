"""Fit a curve to the intensities of an image."""
