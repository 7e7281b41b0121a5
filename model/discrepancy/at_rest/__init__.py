"""What the dynamics of a model explain is taken off measurements before the search."""
