"""The possible answers to each question of a verdict: probabilities and calibrated sets."""
