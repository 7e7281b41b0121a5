"""Subtract what a model's dynamics explain from measurements, before the search."""
