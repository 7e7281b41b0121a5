"""Drawings that are made when the documentation is built; each module has `figure()`."""
