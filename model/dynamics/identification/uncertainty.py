"""From information to intervals: what the data say, what the priors, and what nobody says."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from model.dynamics.identification.parameters import LogParameters
from model.dynamics.identification.thresholds import (
    INTERVAL_SIGMAS,
    MOST_PRIOR,
    MOST_SIGMA,
    UNCERTAIN_SIGMA,
    UNSEEN,
)
from model.measurements import FloatArray, ModelError
from model.parameter import Parameter


@dataclass(frozen=True, kw_only=True)
class DynamicParameter:
    """A parameter of the moving sheet."""

    name: str
    parameter: Parameter
    log_sigma: float  # of its logarithm: about its relative standard uncertainty
    prior_share: float  # of its variance: 0: the data alone, 1: the priors alone
    determined: bool
    other_value: float | None = None  # far from the interval, and explains the data as well

    def text(self) -> str:
        """Return one line for people."""
        value, unit = self.parameter.value, self.parameter.unit
        if not self.determined:
            other = self.other_value
            also = "" if other is None else f"; {other:.3g} {unit} explains them as well"
            return f"{self.name}: these data do not determine it ({value:.3g} {unit} assumed{also})"
        low, high = self.parameter.interval()
        return f"{self.name} = {value:.4g} {unit}, 90 % interval {low:.4g} to {high:.4g}"


def judged(
    parameters: LogParameters, theta: FloatArray, data: FloatArray, scale: float = 1.0,
    guard: float = 1.0,
) -> tuple[tuple[DynamicParameter, ...], FloatArray]:  # fmt: skip
    """Return the parameters with uncertainty, and the covariance (p, p) of their logarithms.

    data: J'J of the whitened residuals. scale: the variance of these, where they are larger than
    the noise explains. guard: the part of the limits within which a parameter is determined. With
    H = J'J/scale + P the covariance H^-1 is the sum of what the data contribute,
    H^-1 (J'J/scale) H^-1, and the priors, H^-1 P H^-1.
    """
    prior = np.diag(parameters.precision)
    covariance = np.linalg.inv(data / scale + prior)
    sigma = np.sqrt(np.diag(covariance))
    share = np.diag(covariance @ prior @ covariance) / sigma**2
    values = parameters.values(theta)
    judged = tuple(
        DynamicParameter(
            name=q.name, log_sigma=float(s), prior_share=float(p),
            determined=bool(p < guard * MOST_PRIOR and s < guard * MOST_SIGMA),
            parameter=Parameter(
                value=values[q.name], sigma=float(s * abs(values[q.name])), unit=q.unit,
                positive=values[q.name] > 0.0,
            ),
        )
        for q, s, p in zip(parameters.quantities, sigma, share, strict=True)
    )  # fmt: skip
    return judged, np.asarray(covariance, dtype=float)


def surely(
    found: tuple[DynamicParameter, ...], covariance: FloatArray, theta: FloatArray,
    begun: FloatArray, there: Callable[[FloatArray], tuple[DynamicParameter, ...]],
) -> tuple[DynamicParameter, ...]:  # fmt: skip
    """Return the parameters as they are at other likely places too: where least is known of each.

    A share that was found too large tells its time too well: with a smaller share, just as likely,
    the same data would not. begun: the logarithms that the priors are about. there: what is found
    at other logarithms; it may raise ModelError.
    """
    for place in _likely_places(found, covariance, theta, begun):
        try:
            others = there(place)
        except ModelError:  # no sheet, or one that leaves the rolls
            continue
        found = tuple(_less_sure(p, q) for p, q in zip(found, others, strict=True))
    return found


def _likely_places(
    found: tuple[DynamicParameter, ...], covariance: FloatArray, theta: FloatArray,
    begun: FloatArray,
) -> Iterator[FloatArray]:  # fmt: skip
    """Yield logarithms: the ends of uncertain intervals, and more of what was too little to see."""
    for k, one in enumerate(found):
        along = covariance[:, k] / one.log_sigma  # the others follow
        if one.determined and one.log_sigma >= UNCERTAIN_SIGMA:
            yield theta - INTERVAL_SIGMAS * along
            yield theta + INTERVAL_SIGMAS * along
        elif one.name in UNSEEN and not one.determined:
            usual = (begun[k] - theta[k]) / one.log_sigma + 1.0
            yield theta + max(INTERVAL_SIGMAS, usual) * along


def _less_sure(one: DynamicParameter, other: DynamicParameter) -> DynamicParameter:
    """Return a parameter with the wider of two intervals, determined where it is so in both."""
    sigma, value = max(one.log_sigma, other.log_sigma), abs(one.parameter.value)
    return replace(
        one, determined=one.determined and other.determined, log_sigma=sigma,
        prior_share=max(one.prior_share, other.prior_share),
        parameter=replace(one.parameter, sigma=sigma * value),
    )  # fmt: skip
