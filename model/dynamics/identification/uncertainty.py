"""From information to intervals: what the data say, what the priors, and what nobody says."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.dynamics.identification.parameters import LogParameters
from model.dynamics.identification.thresholds import MOST_PRIOR, MOST_SIGMA
from model.measurements import FloatArray
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
    parameters: LogParameters, theta: FloatArray, data: FloatArray, scale: float = 1.0
) -> tuple[tuple[DynamicParameter, ...], FloatArray]:
    """Return the parameters with uncertainty, and the covariance (p, p) of their logarithms.

    data: J'J of the whitened residuals. scale: the variance of these, where they are larger than
    the noise explains. With H = J'J/scale + P the covariance H^-1 is the sum of what the data
    contribute, H^-1 (J'J/scale) H^-1, and the priors, H^-1 P H^-1.
    """
    prior = np.diag(parameters.precision)
    covariance = np.linalg.inv(data / scale + prior)
    sigma = np.sqrt(np.diag(covariance))
    share = np.diag(covariance @ prior @ covariance) / sigma**2
    values = parameters.values(theta)
    judged = tuple(
        DynamicParameter(
            name=q.name, log_sigma=float(s), prior_share=float(p),
            determined=bool(p < MOST_PRIOR and s < MOST_SIGMA),
            parameter=Parameter(
                value=values[q.name], sigma=float(s * abs(values[q.name])), unit=q.unit,
                positive=values[q.name] > 0.0,
            ),
        )
        for q, s, p in zip(parameters.quantities, sigma, share, strict=True)
    )  # fmt: skip
    return judged, np.asarray(covariance, dtype=float)
