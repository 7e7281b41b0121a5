"""Numbers that decide what is called determined."""

MOST_PRIOR = 0.25  # of a parameter's variance may come from priors
MOST_SIGMA = 0.5  # of its logarithm: the 90 % interval spans a factor of 5
