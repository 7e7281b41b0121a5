"""Fields that several kinds of protocol have: bounds that the whole folder shares."""

from __future__ import annotations

from dataclasses import field
from typing import Any

LARGEST_VOLTAGE_V = 30.0  # either sign, of any amplifier; the rig's own limit is much lower
LONGEST_S = 3600.0
LARGEST_COUNT = 1000  # of readings, pulses, voltages


def voltage(default_V: float, description: str) -> Any:
    """Return a field for one voltage at the sheet."""
    return field(
        default=default_V,
        metadata={
            "ge": -LARGEST_VOLTAGE_V,
            "le": LARGEST_VOLTAGE_V,
            "unit": "V",
            "description": description,
        },
    )


def voltages(default_V: tuple[float, ...], description: str) -> Any:
    """Return a field for one or more voltages at the sheet, in their order."""
    return field(
        default=default_V,
        metadata={
            "items": {"ge": -LARGEST_VOLTAGE_V, "le": LARGEST_VOLTAGE_V},
            "min_length": 1,
            "max_length": LARGEST_COUNT,
            "unit": "V",
            "description": description,
        },
    )


def duration(default_s: float, description: str, *, may_be_0: bool = False) -> Any:
    """Return a field for a time."""
    return field(
        default=default_s,
        metadata={
            "ge" if may_be_0 else "gt": 0,
            "le": LONGEST_S,
            "unit": "s",
            "description": description,
        },
    )


def count(default: int, description: str, *, at_least: int, repeats: bool = False) -> Any:
    """Return a field for a number of things; `repeats` where readings grow with it."""
    return field(
        default=default,
        metadata={
            "ge": at_least,
            "le": LARGEST_COUNT,
            "repeats": repeats,
            "description": description,
        },
    )
