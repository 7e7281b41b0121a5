"""A sweep over voltages, each held for the same time."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

from protocols.errors import ScheduleError
from protocols.kinds.contract import ProtocolKind
from protocols.kinds.fields import duration, voltages
from protocols.planning.builder import Builder, StepsAndReadings, require_window
from protocols.planning.schedule import ReadingKind


@dataclass(frozen=True, kw_only=True)
class Staircase(ProtocolKind):
    """A sweep over voltages, each held for the same time, with one reading at each.

    A stair at 0 V before the first voltage is a zero reading.
    """

    name: ClassVar[str] = "staircase"

    voltages_V: tuple[float, ...] = voltages(
        (0.5, 1.0, 1.5, 2.0, 1.5, 1.0, 0.5), "of the stairs, in their order"
    )
    dwell_s: float = duration(1.0, "on each stair")
    sample_at_s: float = duration(0.8, "after the edge, as written")
    half_window_s: float = duration(0.1, "half width of the filter")

    def check(self) -> None:
        """Raise ScheduleError unless there is a voltage, and an edge before each reading."""
        if not any(self.voltages_V):
            raise ScheduleError("voltages_V holds no voltage but 0")
        require_window(self.sample_at_s, self.half_window_s, self.dwell_s, "dwell_s")
        for voltage_V, after_V in pairwise(self.voltages_V):
            if voltage_V == after_V:
                raise ScheduleError(
                    f"{voltage_V:g} V follows {voltage_V:g} V without an edge between them"
                )

    def steps_and_readings(self) -> StepsAndReadings:
        """See `ProtocolKind.steps_and_readings`."""
        run = Builder()
        for stair, voltage_V in enumerate(self.voltages_V):
            run.step(voltage_V, self.dwell_s)
            at_rest = stair == 0 and voltage_V == 0
            kind = ReadingKind.ZERO if at_rest else ReadingKind.KEPT
            run.reading(self.sample_at_s, self.half_window_s, kind)
        return run.finish()


PROTOCOL = Staircase
