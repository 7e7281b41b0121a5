"""The uncertainty of a curve, and the biases that belong to it."""
