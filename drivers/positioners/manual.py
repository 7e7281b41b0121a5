"""A stage that is moved by hand: the operator is asked, and answers when it is done."""

from __future__ import annotations

import math
from dataclasses import dataclass

from drivers.interfaces import LimitError, Operator, Positioner, Prompt
from drivers.positioners.contract import PositionerKind, Surroundings


@dataclass(frozen=True)
class ManualSettings:
    """Nothing is to be set of a stage that is moved by hand."""


class ManualStage:
    """A `Positioner` that asks. It does not know where it is."""

    def __init__(self, operator: Operator) -> None:
        self._operator = operator

    def open(self) -> None:
        """Do nothing."""

    def move_to(self, position_m: float) -> bool:
        """See `Positioner.move_to`."""
        if not math.isfinite(position_m):
            raise LimitError(f"{position_m} is no position on the arc; it was not moved")
        text = f"Set the load cell to {position_m * 1e3:g} mm on the arc."
        return self._operator.ask(Prompt(kind="move", text=text, position_m=position_m))

    def position(self) -> float | None:
        """See `Positioner.position`: not known."""
        return None

    def close(self) -> None:
        """Do nothing."""


def _make(_settings: ManualSettings, around: Surroundings) -> Positioner:
    return ManualStage(around.operator)


POSITIONER = PositionerKind(
    kind="manual",
    help="the operator moves the stage by hand and confirms",
    settings=ManualSettings,
    make=_make,
)
