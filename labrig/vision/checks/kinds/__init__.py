"""The checks of a curve, one a file."""
