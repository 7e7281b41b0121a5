"""Numbers as JSON has them."""

from __future__ import annotations

import numpy as np

from model.parameter import Parameter


def parameter_object(one: Parameter) -> dict[str, float | None]:
    """Return the value of a parameter and its standard uncertainty."""
    return {"value": json_number(one.value), "sigma": json_number(one.sigma)}


def json_number(value: float) -> float | None:
    """Return a number that JSON has; others are null."""
    return float(value) if np.isfinite(value) else None
