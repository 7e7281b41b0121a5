"""The sheet's shapes without the load cell, at rest."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import ClassVar

from protocols.errors import ScheduleError
from protocols.extras.contract import Extra, ExtraRun
from protocols.kinds.contract import ProtocolKind
from protocols.kinds.fields import duration
from protocols.planning.builder import Builder, StepsAndReadings
from protocols.planning.pulses import Pulses
from protocols.planning.schedule import AT_REST_S, ReadingKind

EACH = 2  # shapes at every voltage


@dataclass(frozen=True, kw_only=True)
class FreeShapes(Extra):
    """Shapes of the sheet without the load cell, taken at rest.

    A free sheet swings for seconds after an edge, millimetres about its static shape. So shapes
    are taken at 0 V after a rest, and under voltage only where `settled_s` states that the sheet
    has settled by then, or where `moving` asks for them as they are.
    """

    name: ClassVar[str] = "free_shapes"
    by_default: ClassVar[bool] = True

    rest_s: float = duration(AT_REST_S, "at 0 V, before the first shape")
    settled_s: float = duration(
        0.0,
        "after an edge, when the sheet has settled: shapes under voltage are taken then; 0: none",
        may_be_0=True,
    )
    moving: bool = field(
        default=False,
        metadata={
            "description": "shapes under voltage in the protocol's own pulses, where the sheet may "
            "still swing: for the dynamic model"
        },
    )

    def check(self) -> None:
        """Raise ScheduleError where shapes are to be both at rest and moving."""
        if self.moving and self.settled_s:
            raise ScheduleError(
                f"settled_s = {self.settled_s:g} s takes shapes under voltage at rest, and "
                "moving = true takes them before; choose one"
            )

    def runs(
        self,
        protocol: ProtocolKind,
        positions_m: tuple[float, ...],  # noqa: ARG002 - they are away
    ) -> Iterator[ExtraRun]:
        """See `Extra.runs`."""
        yield ExtraRun(parts=self._parts(protocol.pulses()))

    def _parts(self, pulses: Pulses) -> StepsAndReadings:
        run = Builder()
        _take(run, pulses, 0.0, self.rest_s, ReadingKind.ZERO)
        if self.moving:
            pulses.with_readings(EACH).add_to(run)
        elif self.settled_s:
            for voltage_V in dict.fromkeys(pulses.voltages_V):
                _take(run, pulses, voltage_V, self.settled_s, ReadingKind.KEPT)
        return run.finish()


def _take(run: Builder, pulses: Pulses, voltage_V: float, wait_s: float, kind: ReadingKind) -> None:
    """Take shapes at one voltage after a wait, as far apart as pulses are long."""
    wait_s = max(wait_s, pulses.half_window_s)
    run.step(voltage_V, wait_s + (EACH - 1) * pulses.pulse_s + pulses.half_window_s)
    for shape in range(EACH):
        run.reading(wait_s + shape * pulses.pulse_s, pulses.half_window_s, kind)


EXTRA = FreeShapes
