"""The candidates of a result: their ranking, and how well these data show each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from model.discrepancy.verdict.result.json_numbers import json_number
from model.measurements import FloatArray


@dataclass(frozen=True, kw_only=True)
class Ranked:
    """A line of the ranking."""

    name: str
    location: str
    log_bayes: float
    size: float  # most likely size, in units of the plausible one
    detectability: float  # whitened length of the effect at its plausible size
    why_not: str = ""  # why it is not named although it may rank high


@dataclass(frozen=True)
class Signatures:
    """How similar effects are in these data."""

    names: tuple[str, ...]
    detectability: FloatArray  # (n,) sigmas at the plausible size, the base refitted
    distance: FloatArray  # (n, n) sigmas between two of the size found or plausible
    cosine: FloatArray  # (n, n)


@dataclass(frozen=True, kw_only=True)
class DetectionLimit:
    """The amplitude from which on an effect would be seen beside what is named."""

    parameter: str
    value: float
    unit: str
    ratio: float  # over the prior scale

    def to_json(self) -> dict[str, Any]:
        """Return its object in a diagnosis."""
        return {"parameter": self.parameter, "value": json_number(self.value), "unit": self.unit}
