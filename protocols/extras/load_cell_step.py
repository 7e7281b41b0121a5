"""The load cell moved with the sheet between its rolls, at 0 V."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import ClassVar

from protocols.errors import ScheduleError
from protocols.extras.contract import Extra, ExtraRun
from protocols.kinds.contract import ProtocolKind
from protocols.kinds.fields import duration
from protocols.planning.builder import Builder, StepsAndReadings
from protocols.planning.schedule import PlannedMove


def _position(default_mm: float, description: str) -> float:
    made: float = field(
        default=default_mm,
        metadata={"ge": -1000.0, "le": 1000.0, "unit": "mm", "description": description},
    )
    return made


@dataclass(frozen=True, kw_only=True)
class LoadCellStep(Extra):
    """The load cell goes from one position to another, and the force is followed afterwards.

    The sheet is at 0 V all the time. It relaxes after the step, which tells a little of its loss.
    Where the load cell is moved by hand, the operator is asked while the run is recorded.
    """

    name: ClassVar[str] = "load_cell_step"
    dynamic: ClassVar[bool] = True

    from_mm: float = _position(5.0, "where it begins")
    to_mm: float = _position(10.0, "where it goes")
    rest_s: float = duration(1.0, "before it is moved")
    follow_s: float = duration(5.0, "after it has arrived")

    def check(self) -> None:
        """Raise ScheduleError for a step that goes nowhere."""
        if self.from_mm == self.to_mm:
            raise ScheduleError(f"from_mm and to_mm are both {self.from_mm:g} mm")

    def runs(
        self,
        protocol: ProtocolKind,  # noqa: ARG002 - no voltage is applied
        positions_m: tuple[float, ...],
    ) -> Iterator[ExtraRun]:
        """See `Extra.runs`."""
        if positions_m:
            yield ExtraRun(
                parts=self._parts(),
                position_m=self.from_mm / 1000,
                move=PlannedMove(time_s=self.rest_s, position_m=self.to_mm / 1000),
            )

    def _parts(self) -> StepsAndReadings:
        run = Builder()
        run.step(0.0, self.rest_s + self.follow_s)
        return run.finish()


EXTRA = LoadCellStep
