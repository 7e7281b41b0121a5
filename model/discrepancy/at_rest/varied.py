"""Vary each dynamic parameter by a step; the subtracted part is linear in between.

Stiffness and EIBM are those of the base model, which are found with the rest. All other parameters
are as unsure as the model file says.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal

from model.dynamics import DynamicSheet, PronyTerm
from model.measurements import Measurements
from model.parameter import Parameter

# relative: what no parameter is known better than, since the sheet's law is no nature's, nor are
# steps of time infinitely short
LEAST = 0.01
MOST = 0.5  # a parameter that is not known at all may be half as large again
_NAMES = (
    "mass_per_length_kg_per_m", "viscous_time_s", "electrode_ohm_per_m", "capacitance_F_per_m",
    "bulk_ohm_m", "leak_S_per_m",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Step:
    """How other dynamics differ from the stated ones of a configuration."""

    configuration: str
    of: Literal["stiffness", "eibm", "place", "unsure"]  # which parameter differs
    value: float = 0.0  # of the stated dynamics: B in N m^2, Me/B in 1/m
    size: float = 0.0  # how much more it is, relative; of B in its logarithm; of a place in m
    voltage_V: float = 0.0  # of an EIBM


@dataclass(frozen=True)
class Varied:
    """Measurements less what other dynamics explain."""

    step: Step
    measurements: Measurements


def unsure(dynamic: DynamicSheet) -> Iterator[DynamicSheet]:
    """Yield dynamics with one parameter larger by its standard uncertainty.

    The moment per volt is not among them: it is the EIBM, which is found with the rest.
    """
    for name in _NAMES:
        if getattr(dynamic, name).value > 0.0:
            changed: dict[str, Any] = {name: _larger(getattr(dynamic, name))}
            yield replace(dynamic, **changed)
    for i, term in enumerate(dynamic.prony):
        for other in (
            PronyTerm(share=_larger(term.share), time_s=term.time_s),
            PronyTerm(share=term.share, time_s=_larger(term.time_s)),
        ):
            yield replace(dynamic, prony=(*dynamic.prony[:i], other, *dynamic.prony[i + 1 :]))


def _larger(one: Parameter) -> Parameter:
    unsure = min(max(one.sigma / one.value, LEAST), MOST)
    return replace(one, value=one.value * (1.0 + unsure))
