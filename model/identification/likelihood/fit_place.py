"""Where a fit has come to, between its steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.identification.likelihood.model_state import Found
from model.measurements import FloatArray

NEAR = 0.3  # of a standard uncertainty: two places are the same


@dataclass(frozen=True, kw_only=True)
class Place:
    """Where a fit has come to: parameters, effects, and the noise on the way there."""

    theta: FloatArray
    found: tuple[Found, ...]
    log_sigma: FloatArray

    def near(self, other: Place, sigma: FloatArray) -> bool:
        """Return whether another place is the same but for a part of the uncertainties.

        `sigma` is that of the base parameters; effects of no stated uncertainty must be equal.
        """
        if np.any(np.abs(self.theta - other.theta) > NEAR * sigma[: len(self.theta)]):
            return False
        for one, two in zip(self.found, other.found, strict=True):
            for name, values in one.values.items():
                unsure = one.sigma.get(name, {})
                for key, value in values.items():
                    if abs(value - two.values[name][key]) > NEAR * unsure.get(key, 0.0):
                        return False
        return True
