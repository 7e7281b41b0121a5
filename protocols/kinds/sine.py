"""A sine in contact, with readings over its periods."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from protocols.kinds.fields import count, voltage
from protocols.kinds.waveform import Waveform, frequency


@dataclass(frozen=True, kw_only=True)
class Sine(Waveform):
    """A sine about an offset; the readings of its first period are marked as discarded."""

    name: ClassVar[str] = "sine"

    amplitude_V: float = voltage(1.0, "of the sine")
    offset_V: float = voltage(0.0, "about which it swings")
    frequency_hz: float = frequency(0.5, "of the sine")
    periods: int = count(5, "whole ones", at_least=2, repeats=True)

    def check(self) -> None:
        """Raise ScheduleError where writes are too few for the sine, or too many."""
        self.require_writes(self.frequency_hz)

    @property
    def length_s(self) -> float:
        """See `Waveform.length_s`."""
        return self.periods / self.frequency_hz

    @property
    def discarded_s(self) -> float:
        """See `Waveform.discarded_s`."""
        return 1.0 / self.frequency_hz

    def value_V(self, time_s: float) -> float:
        """See `Waveform.value_V`."""
        angle_rad = 2 * math.pi * self.frequency_hz * time_s
        return self.offset_V + self.amplitude_V * math.sin(angle_rad)


PROTOCOL = Sine
