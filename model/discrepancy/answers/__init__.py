"""The answers that compete for each place of a verdict: probabilities and calibrated sets."""
