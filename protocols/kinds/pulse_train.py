"""Readings at 0 V, then pulses of alternating voltages: the paper's protocol."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import ClassVar

from protocols.errors import ScheduleError
from protocols.kinds.bounds import decimal_comma, require_no_0_V
from protocols.kinds.contract import ProtocolKind
from protocols.kinds.fields import count, duration, voltages
from protocols.planning.builder import StepsAndReadings, require_window
from protocols.planning.pulses import Pulses


@dataclass(frozen=True, kw_only=True)
class PulseTrain(ProtocolKind):
    """Readings at 0 V, then pulses of alternating voltages, as in the paper.

    The readings at 0 V come first, as far apart as pulses are long; then one reading in each
    pulse. The first pulses are recorded and marked as discarded; after them every voltage is read
    the stated number of times.
    """

    name: ClassVar[str] = "pulse_train"

    voltages_V: tuple[float, ...] = voltages((2.0, -2.0), "of the pulses, in turn")
    zero_readings: int = count(10, "at 0 V, before the first pulse", at_least=0)
    pulses_discarded: int = count(2, "recorded and marked, not used", at_least=0)
    readings_per_voltage: int = count(10, "one in each pulse", at_least=1, repeats=True)
    pulse_s: float = duration(0.6, "length of a pulse")
    sample_at_s: float = duration(0.5, "after the edge, as written")
    half_window_s: float = duration(0.1, "half width of the filter")
    rest_s: float = duration(0.0, "at 0 V between two pulses", may_be_0=True)

    def check(self) -> None:
        """Raise ScheduleError unless each pulse has an edge and a voltage that tells it apart."""
        require_window(self.sample_at_s, self.half_window_s, self.pulse_s, "pulse_s")
        require_no_0_V(self.voltages_V, "no pulse")
        for entry, voltage_V in enumerate(self.voltages_V):
            if voltage_V in self.voltages_V[:entry]:
                comma = decimal_comma(self.voltages_V, entry)
                raise ScheduleError(f"voltages_V has {voltage_V:g} V twice; state it once{comma}")
        if len(self.voltages_V) == 1 and self.rest_s == 0:
            raise ScheduleError(
                f"{self.voltages_V[0]:g} V follows itself without an edge between the pulses; "
                "set rest_s or change voltages_V"
            )

    def pulses(self) -> Pulses:
        """Return its own pulses."""
        return Pulses(**{field.name: getattr(self, field.name) for field in fields(self)})

    def steps_and_readings(self) -> StepsAndReadings:
        """See `ProtocolKind.steps_and_readings`."""
        return self.pulses().steps_and_readings()


PROTOCOL = PulseTrain
