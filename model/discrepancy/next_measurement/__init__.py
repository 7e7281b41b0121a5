"""Choose the measurement that best separates the remaining candidates."""
