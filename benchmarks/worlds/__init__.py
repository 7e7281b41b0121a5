"""Generators of sessions that share nothing with the model, and what a method says of them."""
