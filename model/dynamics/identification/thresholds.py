"""Numbers that decide what is called determined."""

MOST_PRIOR = 0.25  # of a parameter's variance may come from priors
MOST_SIGMA = 0.5  # of its logarithm: the 90 % interval spans a factor of 5
# What data say of a parameter depends on where the others are, and these are known but roughly.
# A fit calls determined what would be so with an uncertain one at either end of its interval,
UNCERTAIN_SIGMA = 0.1  # of a logarithm: less moves the others' information by little
INTERVAL_SIGMAS = 1.645
GUARD = 0.8  # and keeps this part of both limits: the information is itself an estimate
