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
    low: float = -math.inf  # values beyond these bounds do not exist, such as a share above 1
    high: float = math.inf

    def interval(self, probability: float = 0.9) -> tuple[float, float]:
        """Return the interval of highest density; Student's t for few degrees of freedom.

        The distribution ends at the bounds: the interval holds its share of what lies between them.
        It is symmetric about the value, of its logarithm where `positive`, unless it meets a bound.
        """
        if self.sigma <= 0.0:
            return self.value, self.value
        logarithmic = self.positive and self.value > 0.0
        scale = self.sigma / self.value if logarithmic else self.sigma
        inside = self.low <= self.value <= self.high
        least, most = (self.low, self.high) if inside else (-math.inf, math.inf)
        first, last = (self._reach(bound, scale, logarithmic) for bound in (least, most))
        low, high = _densest(probability, self.freedom, first, last)
        if logarithmic:
            ends = (self.value * _exp(low * scale), self.value * _exp(high * scale))
        else:
            ends = (self.value + low * scale, self.value + high * scale)
        return max(ends[0], least), min(ends[1], most)  # but for rounding they are between

    def _reach(self, bound: float, scale: float, logarithmic: bool) -> float:
        """Return how many `scale` a bound is from the value."""
        if not logarithmic:
            return (bound - self.value) / scale
        return math.log(bound / self.value) / scale if bound > 0.0 else -math.inf

    def scaled(self, factor: float, unit: str) -> Parameter:
        """Return the parameter in another unit, or divided by an exact number."""
        low, high = sorted((self.low * factor, self.high * factor)) if factor else (0.0, 0.0)
        return Parameter(
            value=self.value * factor,
            sigma=self.sigma * abs(factor),
            unit=unit,
            freedom=self.freedom,
            positive=self.positive,
            low=low,
            high=high,
        )

    def to_dict(self) -> dict[str, Any]:
        """For a model file."""
        result: dict[str, Any] = {"value": self.value, "sigma": self.sigma, "unit": self.unit}
        if self.freedom < 9e3:
            result["freedom"] = self.freedom
        if self.positive:
            result["positive"] = True
        bounds = {"low": self.low, "high": self.high}
        return result | {key: bound for key, bound in bounds.items() if math.isfinite(bound)}

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
        low = finite(data["low"], f"{where}.low") if "low" in data else -math.inf
        high = finite(data["high"], f"{where}.high") if "high" in data else math.inf
        return Parameter(
            value=value,
            sigma=sigma,
            unit=str(data.get("unit", "")),
            freedom=freedom,
            positive=data.get("positive") is True,
            low=low,
            high=high,
        )


def _densest(probability: float, freedom: float, first: float, last: float) -> tuple[float, float]:
    """Return the ends that hold a share of Student's t between `first` < 0 and `last` > 0."""
    from scipy.special import stdtr, stdtrit  # slow to import

    below, above = float(stdtr(freedom, first)), float(stdtr(freedom, last))
    mass = probability * (above - below)
    reach = float(stdtrit(freedom, 0.5 + 0.5 * mass))
    if -reach < first and -first <= last:
        return first, float(stdtrit(freedom, below + mass))
    if reach > last:
        return float(stdtrit(freedom, above - mass)), last
    return -reach, reach


def _exp(exponent: float) -> float:
    return math.exp(max(-FARTHEST, min(exponent, FARTHEST)))


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
