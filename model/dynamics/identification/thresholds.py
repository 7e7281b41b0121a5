"""Numbers that decide what is called determined."""

MOST_PRIOR = 0.25  # of a parameter's variance may come from priors
MOST_SIGMA = 0.5  # of its logarithm: the 90 % interval spans a factor of 5
# What data say of a parameter depends on where the others are, and these are known but roughly.
# A fit calls determined what would be so with an uncertain one at either end of its interval,
UNCERTAIN_SIGMA = 0.1  # of a logarithm: less moves the others' information by little
INTERVAL_SIGMAS = 1.645
# and with more of what has no effect, and hides nothing of the others, where it was found too small
UNSEEN = ("viscous_time",)
GUARD = 0.8  # and keeps this part of both limits: the information is itself an estimate
# A fit misses its data where chi2 per value is larger than 1 by both of these:
LEAST_MISFIT = 0.25  # smaller ones only widen the intervals a little
SURE_MISFIT = 5.0  # standard deviations of chi2 per value
# Another place explains the data as well where its cost, over the variance of the residuals, is
# larger by less than
RIVAL = 2.71  # what the 90 % interval of one parameter allows
MOST_LEFT = 4.0  # of a cost, that a search may still have had to gain where it ended
