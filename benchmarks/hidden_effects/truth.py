"""What nobody who is given the session knows."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from sim_hardware.world import Scatter


@dataclass(frozen=True)
class HiddenEffect:
    """One effect as it was hidden."""

    effect: str
    form: str
    size: float
    unit: str
    in_catalogue: bool
    slot: str
    accepted_slots: tuple[str, ...]  # its own among them
    place_mm: tuple[float, float] | None  # along the sheet
    parameters: dict[str, float]  # in the catalogue's units, where this form has them


@dataclass(frozen=True)
class Truth:
    """What is hidden, and the values that a fit should find."""

    effects: tuple[HiddenEffect, ...]  # none: nothing is hidden
    seed: int
    B_Nm2: dict[str, float]
    # mean over the free length of a set-up without scatter, settled
    mean_eibm_Nm: dict[str, dict[float, float]]
    rest_curvature: str
    outlier: int | None  # the run that was set up badly
    scatter: tuple[Scatter, ...]  # of each run

    @property
    def names(self) -> tuple[str, ...]:
        """What should be found; empty: nothing."""
        return tuple(e.effect for e in self.effects)

    def to_dict(self) -> dict[str, Any]:
        """As plain data for JSON."""
        return asdict(self)
