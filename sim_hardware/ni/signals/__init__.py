"""Sampled signals: timing, converters, acquisition."""
