"""Other places that explain the data as well: a search ends in one of several minima."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from math import log

from model.dynamics.identification.search import NEAR, SearchEnd, SearchProblem, search
from model.dynamics.identification.thresholds import GUARD, INTERVAL_SIGMAS, MOST_SIGMA, RIVAL
from model.dynamics.identification.uncertainty import DynamicParameter
from model.measurements import FloatArray


def best_and_rivals(
    problem: SearchProblem, first: SearchEnd, beginnings: Iterable[FloatArray], tolerance: float
) -> tuple[SearchEnd, list[SearchEnd]]:
    """Return the end of least cost, and those that the noise does not tell from it.

    beginnings: where to search besides `first`.
    """
    ends = [first, *(search(problem, theta, NEAR) for theta in beginnings)]
    best = min(ends, key=lambda end: end.at.cost)
    others = [end for end in ends if end is not best]
    if best is not first:
        best = search(problem, best.at.theta, tolerance, finish=True)
    scale = max(1.0, best.at.chi2 / problem.count)
    return best, [end for end in others if end.least_cost < best.at.cost + RIVAL * scale]


def covering_both(
    found: tuple[DynamicParameter, ...], rival: tuple[DynamicParameter, ...]
) -> tuple[DynamicParameter, ...]:
    """Return parameters whose intervals cover those of both, or that are not determined."""
    return tuple(_covering(one, other) for one, other in zip(found, rival, strict=True))


def _covering(one: DynamicParameter, other: DynamicParameter) -> DynamicParameter:
    value = one.parameter.value
    away = abs(log(other.parameter.value / value))
    if away + INTERVAL_SIGMAS * other.log_sigma <= INTERVAL_SIGMAS * one.log_sigma:
        return one
    sigma = away / INTERVAL_SIGMAS + other.log_sigma
    determined = one.determined and other.determined and sigma < GUARD * MOST_SIGMA
    apart = away > INTERVAL_SIGMAS * one.log_sigma  # it is another value, not the same less sure
    return replace(
        one, determined=determined, log_sigma=sigma,
        prior_share=max(one.prior_share, other.prior_share),
        other_value=other.parameter.value if apart else one.other_value,
        parameter=replace(one.parameter, sigma=sigma * abs(value)),
    )  # fmt: skip
