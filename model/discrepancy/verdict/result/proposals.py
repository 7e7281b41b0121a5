"""The next measurement of a result, and what earlier proposals promised."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from model.discrepancy.verdict.result.json_numbers import json_number


@dataclass(frozen=True, kw_only=True)
class Next:
    """The next measurement, for a verdict with higher probability."""

    why: str
    extra: str  # name of the entry of the menu
    separation: float  # sigmas between the candidates now
    expected: float  # and after it
    minutes: float
    protocol: Mapping[str, Any]  # tables of a protocol.toml
    between: tuple[str, ...] = ()  # the candidates; older diagnoses do not say

    def to_json(self) -> dict[str, Any]:
        """Return its object in a diagnosis."""
        return {
            "why": self.why,
            "protocol": dict(self.protocol),
            "between": list(self.between),
            "separation_now": json_number(self.separation),
            "separation_expected": json_number(self.expected),
            "minutes": json_number(self.minutes),
        }


@dataclass(frozen=True)
class Promise:
    """A proposed measurement that was made, and how far apart the candidates are with it."""

    proposal: Next
    found: float  # sigmas between the candidates, the measurement included

    def to_json(self) -> dict[str, Any]:
        """Return its object in a diagnosis."""
        return {
            "between": list(self.proposal.between),
            "extra": self.proposal.extra,
            "separation_before": json_number(self.proposal.separation),
            "separation_promised": json_number(self.proposal.expected),
            "separation_found": json_number(self.found),
        }
