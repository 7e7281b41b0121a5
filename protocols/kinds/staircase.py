"""A sweep over voltages, each held for the same time."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from protocols.errors import ScheduleError, require_number
from protocols.kinds.definition import Builder, StepsAndReadings, require_window
from protocols.planning.schedule import ReadingKind


@dataclass(frozen=True)
class Staircase:
    """One reading on each stair; a stair at 0 V before the first voltage is a zero reading."""

    voltages_V: tuple[float, ...] = (0.5, 1.0, 1.5, 2.0, 1.5, 1.0, 0.5)
    dwell_s: float = 1.0
    sample_at_s: float = 0.8  # after the edge, as written
    half_window_s: float = 0.1

    def __post_init__(self) -> None:
        what = self.name
        if not any(self.voltages_V):
            raise ScheduleError(f"{what}: voltages_V holds no voltage but 0")
        for voltage_V in self.voltages_V:
            require_number(f"{what}: a voltage", voltage_V)
        for key in ("dwell_s", "sample_at_s", "half_window_s"):
            require_number(f"{what}: {key}", getattr(self, key), above=0.0)
        require_window(what, self.sample_at_s, self.half_window_s, self.dwell_s, "dwell_s")
        for voltage_V, after_V in pairwise(self.voltages_V):
            if voltage_V == after_V:
                raise ScheduleError(
                    f"{what}: {voltage_V:g} V follows {voltage_V:g} V without an edge between them"
                )

    @property
    def name(self) -> str:
        """See `Definition.name`."""
        return "staircase"

    def steps_and_readings(self) -> StepsAndReadings:
        """See `Definition.steps_and_readings`."""
        run = Builder()
        for stair, voltage_V in enumerate(self.voltages_V):
            run.step(voltage_V, self.dwell_s)
            at_rest = stair == 0 and voltage_V == 0
            kind = ReadingKind.ZERO if at_rest else ReadingKind.KEPT
            run.reading(self.sample_at_s, self.half_window_s, kind)
        return run.finish()
