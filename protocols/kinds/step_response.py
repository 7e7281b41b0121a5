"""One step of the voltage: the response before, during and after it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from protocols.errors import ScheduleError
from protocols.kinds.contract import ProtocolKind
from protocols.kinds.fields import duration, voltage
from protocols.planning.builder import Builder, StepsAndReadings, require_kept
from protocols.planning.schedule import ReadingKind


@dataclass(frozen=True, kw_only=True)
class StepResponse(ProtocolKind):
    """One step of the voltage, with readings before, during and after it.

    Readings are of kind zero before, kept during, and discarded after the step: the sheet is at
    0 V again, but its water has not settled. The raw signals hold everything in between.
    """

    name: ClassVar[str] = "step_response"

    voltage_V: float = voltage(2.0, "of the step")
    hold_s: float = duration(10.0, "length of the step")
    sample_every_s: float = duration(0.5, "from one reading to the next")
    before_s: float = duration(2.0, "at 0 V before the step")
    after_s: float = duration(5.0, "at 0 V after the step")

    def check(self) -> None:
        """Raise ScheduleError unless there is a step, and a reading in it."""
        if self.voltage_V == 0:
            raise ScheduleError("voltage_V = 0 is no step")
        require_kept(self.steps_and_readings(), self.hold_s, self.sample_every_s)

    def steps_and_readings(self) -> StepsAndReadings:
        """See `ProtocolKind.steps_and_readings`."""
        run = Builder()
        for voltage_V, lasts_s, kind in (
            (0.0, self.before_s, ReadingKind.ZERO),
            (self.voltage_V, self.hold_s, ReadingKind.KEPT),
            (0.0, self.after_s, ReadingKind.DISCARDED),
        ):
            run.step(voltage_V, lasts_s)
            run.readings_every(self.sample_every_s, lasts_s, kind)
        return run.finish()


PROTOCOL = StepResponse
