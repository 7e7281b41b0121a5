"""Kinds of protocol: how a definition becomes voltage steps and readings."""
