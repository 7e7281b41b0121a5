"""What all rows of a batch say together."""
