"""From information to intervals: what the data say, what the priors, and what nobody says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from model.dynamics.identification.parameters import LogParameters
from model.dynamics.identification.thresholds import (
    INTERVAL_SIGMAS,
    MOST_PRIOR,
    MOST_SIGMA,
    UNCERTAIN_SIGMA,
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

    def text(self) -> str:
        """Return one line for people."""
        value, unit = self.parameter.value, self.parameter.unit
        if not self.determined:
            return f"{self.name}: these data do not determine it ({value:.3g} {unit} assumed)"
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
    there: Callable[[FloatArray], tuple[DynamicParameter, ...]],
) -> tuple[DynamicParameter, ...]:  # fmt: skip
    """Return the parameters; determined is what is so at the ends of uncertain intervals too.

    A share that was found too large tells its time too well: with a smaller share, just as likely,
    the same data would not. there: what is found at other logarithms; it may raise ModelError.
    """
    for k, one in enumerate(found):
        if not one.determined or one.log_sigma < UNCERTAIN_SIGMA:
            continue
        along = INTERVAL_SIGMAS * covariance[:, k] / one.log_sigma
        for end in (theta - along, theta + along):
            try:
                others = there(end)
            except ModelError:  # no sheet, or one that leaves the rolls
                continue
            found = tuple(
                replace(p, determined=p.determined and q.determined)
                for p, q in zip(found, others, strict=True)
            )
    return found
