"""A sine whose frequency goes from one end to the other."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from protocols.kinds.fields import count, duration, voltage
from protocols.kinds.waveform import Waveform, frequency


@dataclass(frozen=True, kw_only=True)
class Sweep(Waveform):
    """A sine whose frequency changes by the same factor in equal times, once or several times."""

    name: ClassVar[str] = "sweep"

    amplitude_V: float = voltage(1.0, "of the sine")
    start_hz: float = frequency(0.1, "frequency at the beginning")
    end_hz: float = frequency(5.0, "frequency at the end")
    sweep_s: float = duration(20.0, "from the one to the other")
    sweeps: int = count(1, "one after the other", at_least=1, repeats=True)

    def check(self) -> None:
        """Raise ScheduleError where writes are too few for the sine, or too many."""
        self.require_writes(max(self.start_hz, self.end_hz))

    @property
    def length_s(self) -> float:
        """See `Waveform.length_s`."""
        return self.sweeps * self.sweep_s

    def value_V(self, time_s: float) -> float:
        """See `Waveform.value_V`."""
        return self.amplitude_V * math.sin(self._phase_rad(time_s % self.sweep_s))

    def _phase_rad(self, time_s: float) -> float:
        """Return 2 pi times the integral of f(t) = f0 (f1/f0)^(t/T)."""
        ratio = math.log(self.end_hz / self.start_hz)
        if ratio == 0.0:
            return 2 * math.pi * self.start_hz * time_s
        grown = math.expm1(ratio * time_s / self.sweep_s)
        return 2 * math.pi * self.start_hz * self.sweep_s / ratio * grown


PROTOCOL = Sweep
