"""Noise of the rows: its kinds, and the covariance that it and the scatter of set-ups make."""
