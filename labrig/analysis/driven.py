"""Whether measurements can say anything about the EIBM."""

from __future__ import annotations

from labrig.errors import BadInputError
from model.measurements import Measurements


def require_driven(measurements: Measurements) -> None:
    """Raise BadInputError unless something was measured under voltage."""
    if not any(condition.voltage_V for condition in measurements.conditions):
        raise BadInputError(
            "nothing was measured under voltage, so there is no EIBM to be found; measure at 0 V"
            " and at one voltage at least."
        )
