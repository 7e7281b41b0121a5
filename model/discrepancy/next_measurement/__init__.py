"""Choose the measurement that best separates the candidates that are left."""
