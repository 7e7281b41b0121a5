"""Hold a voltage and return to 0 V, several times: creep and relaxation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from protocols.errors import ScheduleError
from protocols.kinds.contract import ProtocolKind
from protocols.kinds.fields import count, duration, voltage
from protocols.planning.builder import Builder, StepsAndReadings, require_kept
from protocols.planning.schedule import ReadingKind


@dataclass(frozen=True, kw_only=True)
class Hold(ProtocolKind):
    """Hold a voltage and return to 0 V, several times: creep and relaxation.

    Readings are of kind zero before the first hold, kept while held, discarded while relaxing.
    """

    name: ClassVar[str] = "hold"

    voltage_V: float = voltage(2.0, "that is held")
    hold_s: float = duration(5.0, "at the voltage")
    relax_s: float = duration(5.0, "at 0 V, first and after each hold")
    cycles: int = count(3, "holds, each with its relaxation", at_least=1, repeats=True)
    sample_every_s: float = duration(0.5, "from one reading to the next")

    def check(self) -> None:
        """Raise ScheduleError unless there is a voltage to hold, and a reading while it is held."""
        if self.voltage_V == 0:
            raise ScheduleError("voltage_V = 0 holds nothing")
        require_kept(self.steps_and_readings(), self.hold_s, self.sample_every_s)

    def steps_and_readings(self) -> StepsAndReadings:
        """See `ProtocolKind.steps_and_readings`."""
        run = Builder()
        run.step(0.0, self.relax_s)
        run.readings_every(self.sample_every_s, self.relax_s, ReadingKind.ZERO)
        for _ in range(self.cycles):
            run.step(self.voltage_V, self.hold_s)
            run.readings_every(self.sample_every_s, self.hold_s, ReadingKind.KEPT)
            run.step(0.0, self.relax_s)
            run.readings_every(self.sample_every_s, self.relax_s, ReadingKind.DISCARDED)
        return run.finish()


PROTOCOL = Hold
