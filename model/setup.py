"""What a beam problem is made of, before it is solved: the place where effects act.

An effect changes a `Setup` before the equilibrium is sought. None is known yet: `EFFECTS` is where
they are entered.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

from model.field import Field
from model.measurements import SheetGeometry
from model.parameter import Parameter


@dataclass(frozen=True)
class Setup:
    """One configuration at one position and voltage."""

    sheet: SheetGeometry
    voltage_V: float
    angle_rad: float  # polar angle of the contact
    B_Nm2: float  # the reference stiffness
    rest: Field  # k0(s)
    eibm: Field  # Me(s)
    softness: Field | None = None  # B/B(s); None: the same stiffness everywhere
    clamp_rad: float = 0.0  # direction in which the sheet leaves the clamp


@dataclass(frozen=True)
class ActiveEffect:
    """An effect that a model includes, by its name in the catalogue."""

    name: str
    parameters: dict[str, Parameter] = field(default_factory=dict)


class Effect(Protocol):
    """What an entry of `EFFECTS` does."""

    def apply(self, setup: Setup, parameters: dict[str, float]) -> Setup:
        """The changed problem. Must not fail for parameters within their bounds."""


EFFECTS: dict[str, Effect] = {}
