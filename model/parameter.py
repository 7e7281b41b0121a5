"""A number with its standard uncertainty and unit."""

from __future__ import annotations

import math
import reprlib
from dataclasses import dataclass
from typing import Any

from model.measurements import ModelError

FARTHEST = 20.0  # of a logarithm; beyond it nothing is known


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """A fitted or assumed number."""

    value: float
    sigma: float  # standard uncertainty; 0: taken as exact
    unit: str
    freedom: float = 1e4  # degrees of freedom behind sigma
    positive: bool = False  # its logarithm is what is uncertain, by sigma over value

    def interval(self, probability: float = 0.9) -> tuple[float, float]:
        """Return the central interval; Student's t for few degrees of freedom."""
        from scipy.special import stdtrit  # slow to import

        reach = float(stdtrit(self.freedom, 0.5 + 0.5 * probability)) * self.sigma
        if self.positive and self.value > 0.0:
            factor = math.exp(min(reach / self.value, FARTHEST))
            return self.value / factor, self.value * factor
        return self.value - reach, self.value + reach

    def scaled(self, factor: float, unit: str) -> Parameter:
        """Return the parameter in another unit, or divided by an exact number."""
        sigma = self.sigma * abs(factor)
        return Parameter(
            value=self.value * factor,
            sigma=sigma,
            unit=unit,
            freedom=self.freedom,
            positive=self.positive,
        )

    def to_dict(self) -> dict[str, Any]:
        """For a model file."""
        result: dict[str, Any] = {"value": self.value, "sigma": self.sigma, "unit": self.unit}
        if self.freedom < 9e3:
            result["freedom"] = self.freedom
        if self.positive:
            result["positive"] = True
        return result

    def to_json(self) -> dict[str, Any]:
        """For `--json`."""
        low, high = self.interval()
        return {"value": self.value, "sigma": self.sigma, "interval90": [low, high]}

    @staticmethod
    def from_dict(data: object, where: str) -> Parameter:
        """From a model file; `where` names the place in errors."""
        if not isinstance(data, dict):
            raise ModelError(f"{where}: a table with value, sigma and unit is wanted")
        value = finite(data.get("value"), f"{where}.value")
        sigma = finite(data.get("sigma", 0.0), f"{where}.sigma")
        freedom = finite(data.get("freedom", 1e4), f"{where}.freedom")
        if sigma < 0.0 or freedom <= 0.0:
            raise ModelError(f"{where}: sigma must not be negative, freedom must be positive")
        unit, positive = str(data.get("unit", "")), data.get("positive") is True
        return Parameter(value=value, sigma=sigma, unit=unit, freedom=freedom, positive=positive)


def finite(value: object, where: str) -> float:
    """Return a finite number; raise an error that names the place where it is not finite."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        try:
            number = float(value)
        except OverflowError:  # an integer with hundreds of digits
            number = math.inf
        if math.isfinite(number):
            return number
    raise ModelError(f"{where}: a finite number is wanted, found {reprlib.repr(value)}")
