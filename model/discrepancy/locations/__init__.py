"""Components of the model that may be wrong, each with its nonparametric terms."""
