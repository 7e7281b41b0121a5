"""How unsure the refined parameters of an effect are, and how many degrees of freedom tell it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray


@dataclass(frozen=True)
class Uncertainty:
    """Of a parameter, in its own unit."""

    column: int  # among all parameters of the fit
    sigma: float
    freedom: float


def uncertainties(final: MixedModelFit, place: int, name: str) -> dict[str, Uncertainty]:
    """Return those of an effect's parameters in a configuration.

    The sigma holds what other shapes of the effect make (`Found.sigma`), and what the scatter does
    that the data are weighed by, which is estimated, too. The degrees of freedom are those of the
    fit that is written.
    """
    one, span = final.found[place], final.spans[place]
    stated, result = one.sigma.get(name, {}), dict[str, Uncertainty]()
    at_scatter = np.diag(final.solution.covariance)
    more = np.diag(final.covariance) - at_scatter
    for i, (parameter, names) in enumerate(one.parameters(), span.start):
        key = parameter.name
        if name in names and key in stated and at_scatter[i] > 0.0:
            scale = one.values[name][key] if parameter.log else 1.0
            sigma = float(np.hypot(stated[key], abs(scale) * np.sqrt(more[i])))
            result[key] = Uncertainty(i, sigma, final.freedom(_only(i, len(at_scatter))))
    return result


def _only(i: int, count: int) -> FloatArray:
    direction: FloatArray = np.zeros(count)
    direction[i] = 1.0
    return direction
