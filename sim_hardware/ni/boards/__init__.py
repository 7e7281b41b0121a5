"""Simulated NI boards."""
