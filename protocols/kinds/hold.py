"""Hold a voltage, let go, again and again: creep and relaxation."""

from __future__ import annotations

from dataclasses import dataclass

from protocols.errors import ScheduleError, require_count, require_number
from protocols.kinds.definition import Builder, StepsAndReadings
from protocols.planning.schedule import ReadingKind


@dataclass(frozen=True)
class Hold:
    """`relax_s` at 0 V to begin with, then `cycles` times the voltage for `hold_s` and 0 V again.

    Readings are of kind zero before the first hold, kept while held, discarded while relaxing.
    """

    voltage_V: float = 2.0
    hold_s: float = 5.0
    relax_s: float = 5.0
    cycles: int = 3
    sample_every_s: float = 0.5

    def __post_init__(self) -> None:
        require_number(f"{self.name}: voltage_V", self.voltage_V)
        for key in ("hold_s", "relax_s", "sample_every_s"):
            require_number(f"{self.name}: {key}", getattr(self, key), above=0.0)
        require_count(f"{self.name}: cycles", self.cycles, least=1)
        if self.voltage_V == 0:
            raise ScheduleError(f"{self.name}: voltage_V = 0 holds nothing")
        if not any(r.kind is ReadingKind.KEPT for r in self.steps_and_readings()[1]):
            raise ScheduleError(
                f"{self.name}: no reading fits into hold_s = {self.hold_s:g} s; "
                f"make sample_every_s = {self.sample_every_s:g} s smaller"
            )

    @property
    def name(self) -> str:
        """See `Definition.name`."""
        return "hold"

    def steps_and_readings(self) -> StepsAndReadings:
        """See `Definition.steps_and_readings`."""
        run = Builder()
        run.step(0.0, self.relax_s)
        run.readings_every(self.sample_every_s, self.relax_s, ReadingKind.ZERO)
        for _ in range(self.cycles):
            run.step(self.voltage_V, self.hold_s)
            run.readings_every(self.sample_every_s, self.hold_s, ReadingKind.KEPT)
            run.step(0.0, self.relax_s)
            run.readings_every(self.sample_every_s, self.relax_s, ReadingKind.DISCARDED)
        return run.finish()
