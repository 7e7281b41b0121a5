"""A sum of sines: several frequencies at the same time."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import ClassVar

from protocols.errors import ScheduleError
from protocols.kinds.fields import count, voltage
from protocols.kinds.waveform import Waveform, frequency, schroeder_phases_rad

_MOST_SINES = 40


@dataclass(frozen=True, kw_only=True)
class MultiSine(Waveform):
    """Sines of equal size at whole multiples of a base frequency, with phases of a low peak.

    Its largest voltage is `peak_V`. The readings of the first period are marked as discarded.
    """

    name: ClassVar[str] = "multi_sine"

    peak_V: float = voltage(1.0, "largest voltage of the sum")
    base_hz: float = frequency(0.2, "one period of the sum is 1/base_hz")
    harmonics: tuple[float, ...] = field(
        default=(1.0, 3.0, 5.0, 9.0, 15.0),
        metadata={
            "items": {"ge": 1, "le": 1000},
            "min_length": 1,
            "max_length": _MOST_SINES,
            "description": "multiples of base_hz, whole numbers",
        },
    )
    periods: int = count(3, "whole ones, of the sum", at_least=2, repeats=True)

    def check(self) -> None:
        """Raise ScheduleError unless the multiples are whole, and the writes are enough."""
        if any(not float(n).is_integer() for n in self.harmonics):
            raise ScheduleError("harmonics must be whole numbers: else the sum has no period")
        if len(set(self.harmonics)) < len(self.harmonics):
            raise ScheduleError("harmonics has a number twice")
        self.require_writes(self.base_hz * max(self.harmonics))

    @property
    def length_s(self) -> float:
        """See `Waveform.length_s`."""
        return self.periods / self.base_hz

    @property
    def discarded_s(self) -> float:
        """See `Waveform.discarded_s`."""
        return 1.0 / self.base_hz

    def value_V(self, time_s: float) -> float:
        """See `Waveform.value_V`."""
        peak = _peak(self.harmonics, self.base_hz * self.write_every_s)
        return self.peak_V * _sum(self.harmonics, self.base_hz * time_s) / peak


def _sum(harmonics: tuple[float, ...], turn: float) -> float:
    """Return the sum of the sines; `turn` counts periods of the base frequency."""
    phases = schroeder_phases_rad(len(harmonics))
    return sum(math.cos(2 * math.pi * n * turn + p) for n, p in zip(harmonics, phases, strict=True))


@lru_cache(maxsize=32)
def _peak(harmonics: tuple[float, ...], step: float) -> float:
    """Return the largest value of the sum, of those that are written too."""
    count = max(16, math.ceil(max(harmonics))) * 64
    grid = [k / count for k in range(count)]
    written = [(k + 0.5) * step for k in range(max(1, math.ceil(1.0 / step)))]
    return max(abs(_sum(harmonics, turn)) for turn in (*grid, *written))


PROTOCOL = MultiSine
