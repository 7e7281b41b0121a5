"""A waveform: a voltage that changes all the time, written in short steps, read at intervals.

Not a kind of protocol by itself: the kinds that follow a function of time share it.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass, field, replace

from protocols.errors import ScheduleError
from protocols.kinds.contract import ProtocolKind
from protocols.kinds.fields import duration
from protocols.planning.builder import DECIMALS, Builder, StepsAndReadings
from protocols.planning.pulses import Pulses
from protocols.planning.schedule import ReadingKind

LEAST_WRITES = 10  # in a period: fewer make stairs of a sine
HIGHEST_HZ = 50.0
_MAX_WRITES = 50_000  # of one run
_WINDOW = 0.45  # half width of a reading's window over the step that it lies in


def frequency(default_hz: float, description: str) -> float:
    """Return a field for a frequency."""
    facts = {"gt": 0, "le": HIGHEST_HZ, "unit": "Hz", "description": description}
    made: float = field(default=default_hz, metadata=facts)
    return made


@dataclass(frozen=True, kw_only=True)
class Waveform(ProtocolKind):
    """A function of time, held at its value in the middle of each step."""

    write_every_s: float = field(
        default=0.02,
        metadata={
            "ge": 0.005,
            "le": 1.0,
            "unit": "s",
            "description": "between two writes of the voltage",
        },
    )
    read_every_s: float = duration(0.2, "between two readings, in the middle of a step")
    rest_s: float = duration(1.0, "at 0 V before it, with a reading")

    @property
    @abstractmethod
    def length_s(self) -> float:
        """How long it lasts."""

    @abstractmethod
    def value_V(self, time_s: float) -> float:
        """Return the voltage at a time since its beginning."""

    @property
    def discarded_s(self) -> float:
        """How long it takes until readings count: what begins is not what goes on."""
        return 0.0

    def steps_and_readings(self) -> StepsAndReadings:
        """See `ProtocolKind.steps_and_readings`."""
        run = Builder()
        run.step(0.0, self.rest_s)
        run.reading(0.8 * self.rest_s, 0.1 * self.rest_s, ReadingKind.ZERO)
        every = max(1, round(self.read_every_s / self.write_every_s))
        for write in range(self._writes()):
            middle_s = (write + 0.5) * self.write_every_s
            run.step(self.value_V(middle_s), self.write_every_s)
            if (write + 1) % every == 0:
                kept = middle_s >= self.discarded_s
                kind = ReadingKind.KEPT if kept else ReadingKind.DISCARDED
                run.reading(0.5 * self.write_every_s, _WINDOW * self.write_every_s, kind)
        return run.finish()

    def pulses(self) -> Pulses:
        """Return pulses at its largest voltages: one at each of them would be hundreds."""
        steps = self.steps_and_readings()[0]
        ends_V = {max(s.voltage_V for s in steps), min(s.voltage_V for s in steps)}
        pulses = ProtocolKind.pulses(_Ends(ends_V=tuple(sorted(ends_V - {0.0}, reverse=True))))
        return replace(pulses, rest_s=pulses.pulse_s if len(pulses.voltages_V) == 1 else 0.0)

    def require_writes(self, highest_hz: float) -> None:
        """Raise ScheduleError where the writes are too few for a frequency, or too many."""
        if highest_hz * self.write_every_s * LEAST_WRITES > 1.0 + 10.0**-DECIMALS:
            raise ScheduleError(
                f"{highest_hz:g} Hz written every {self.write_every_s:g} s is less than "
                f"{LEAST_WRITES} writes a period; make write_every_s at most "
                f"{1.0 / (LEAST_WRITES * highest_hz):.3g} s or the frequency lower"
            )
        self.require_length()

    def require_length(self) -> None:
        """Raise ScheduleError where it makes more writes than can be meant."""
        if self.length_s / self.write_every_s > _MAX_WRITES:
            raise ScheduleError(
                f"{self.length_s:g} s written every {self.write_every_s:g} s is more than "
                f"{_MAX_WRITES} writes; make it shorter"
            )
        if self.read_every_s > self.length_s:
            raise ScheduleError(
                f"read_every_s = {self.read_every_s:g} s is longer than the waveform "
                f"({self.length_s:g} s): nothing would be read"
            )

    def _writes(self) -> int:
        return max(1, round(self.length_s / self.write_every_s))


@dataclass(frozen=True, kw_only=True)
class _Ends(ProtocolKind):
    """The voltages of a waveform that pulses are made of."""

    ends_V: tuple[float, ...]

    @property
    def driven_V(self) -> tuple[float, ...]:
        """See `ProtocolKind.driven_V`."""
        return self.ends_V or (0.0,)

    def steps_and_readings(self) -> StepsAndReadings:
        """Nobody runs it."""
        raise NotImplementedError


def schroeder_phases_rad(count: int) -> list[float]:
    """Return phases that keep the peak of a sum of equal sines low (Schroeder 1970)."""
    return [-math.pi * k * (k - 1) / count for k in range(1, count + 1)]
