"""One step of the voltage, held and watched."""

from __future__ import annotations

from dataclasses import dataclass

from protocols.errors import ScheduleError, require_number
from protocols.kinds.definition import Builder, StepsAndReadings
from protocols.planning.schedule import ReadingKind


@dataclass(frozen=True)
class StepResponse:
    """0 V for `before_s`, the voltage for `hold_s`, 0 V again for `after_s`.

    Readings are of kind zero before, kept during, and discarded after the step: the sheet is at
    0 V again, but its water has not settled. The raw signals hold everything in between.
    """

    voltage_V: float = 2.0
    hold_s: float = 10.0
    sample_every_s: float = 0.5
    before_s: float = 2.0
    after_s: float = 5.0

    def __post_init__(self) -> None:
        require_number(f"{self.name}: voltage_V", self.voltage_V)
        for key in ("hold_s", "sample_every_s", "before_s", "after_s"):
            require_number(f"{self.name}: {key}", getattr(self, key), above=0.0)
        if self.voltage_V == 0:
            raise ScheduleError(f"{self.name}: voltage_V = 0 is no step")
        if not any(r.kind is ReadingKind.KEPT for r in self.steps_and_readings()[1]):
            raise ScheduleError(
                f"{self.name}: no reading fits into hold_s = {self.hold_s:g} s; "
                f"make sample_every_s = {self.sample_every_s:g} s smaller"
            )

    @property
    def name(self) -> str:
        """See `Definition.name`."""
        return "step_response"

    def steps_and_readings(self) -> StepsAndReadings:
        """See `Definition.steps_and_readings`."""
        run = Builder()
        for voltage_V, lasts_s, kind in (
            (0.0, self.before_s, ReadingKind.ZERO),
            (self.voltage_V, self.hold_s, ReadingKind.KEPT),
            (0.0, self.after_s, ReadingKind.DISCARDED),
        ):
            run.step(voltage_V, lasts_s)
            run.readings_every(self.sample_every_s, lasts_s, kind)
        return run.finish()
