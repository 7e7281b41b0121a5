"""Fits of candidates with all parameters free."""
