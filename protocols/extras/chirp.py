"""A sine sweep in contact: what tells the electrodes' time constants."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import ClassVar

from protocols.errors import ScheduleError
from protocols.extras.contract import (
    Extra,
    ExtraRun,
    largest_V,
    middle,
    positions_or_middle,
)
from protocols.kinds.contract import ProtocolKind
from protocols.kinds.fields import LARGEST_VOLTAGE_V, duration
from protocols.planning.builder import Builder, StepsAndReadings

LEAST_WRITES = 10  # a period: fewer make stairs of a sine
MAX_WRITES = 20_000  # of one sweep
_HIGHEST_HZ = 100.0


def _frequency(default_hz: float, description: str) -> float:
    made: float = field(
        default=default_hz,
        metadata={"gt": 0, "le": _HIGHEST_HZ, "unit": "Hz", "description": description},
    )
    return made


@dataclass(frozen=True, kw_only=True)
class Chirp(Extra):
    """A sine whose frequency rises (or falls) by the same factor in equal times.

    It is written as steps, each held at the sine's value in its middle; what the board wrote is
    recorded, and the drive as read back.
    """

    name: ClassVar[str] = "chirp"
    dynamic: ClassVar[bool] = True

    start_hz: float = _frequency(0.2, "frequency at the beginning")
    end_hz: float = _frequency(10.0, "frequency at the end")
    duration_s: float = duration(12.0, "of the sweep")
    amplitude_V: float = field(
        default=0.0,
        metadata={
            "ge": 0,
            "le": LARGEST_VOLTAGE_V,
            "unit": "V",
            "description": "of the sine; 0: the largest voltage of the protocol",
        },
    )
    write_every_s: float = field(
        default=0.01,
        metadata={
            "ge": 0.002,
            "le": 1.0,
            "unit": "s",
            "description": "between two writes of the voltage",
        },
    )
    positions_mm: tuple[float, ...] = positions_or_middle(
        "where it is run; none: at the middle position of the place"
    )

    def check(self) -> None:
        """Raise ScheduleError where writes are too few for the sine, or too many."""
        highest_hz = max(self.start_hz, self.end_hz)
        if highest_hz * self.write_every_s * LEAST_WRITES > 1.0 + 1e-9:
            raise ScheduleError(
                f"{highest_hz:g} Hz written every {self.write_every_s:g} s is less than "
                f"{LEAST_WRITES} writes a period; make write_every_s at most "
                f"{1.0 / (LEAST_WRITES * highest_hz):.3g} s or the frequency lower"
            )
        if self.duration_s / self.write_every_s > MAX_WRITES:
            raise ScheduleError(
                f"{self.duration_s:g} s written every {self.write_every_s:g} s is more than "
                f"{MAX_WRITES} writes; make the sweep shorter"
            )

    def runs(self, protocol: ProtocolKind, positions_m: tuple[float, ...]) -> Iterator[ExtraRun]:
        """See `Extra.runs`."""
        parts = self._parts(self.amplitude_V or abs(largest_V(protocol)))
        wanted_m = tuple(position_mm / 1000 for position_mm in self.positions_mm)
        for position_m in wanted_m or middle(positions_m):
            yield ExtraRun(parts=parts, position_m=position_m)

    def _parts(self, amplitude_V: float) -> StepsAndReadings:
        run = Builder()
        count = max(1, round(self.duration_s / self.write_every_s))
        for write in range(count):
            middle_s = (write + 0.5) * self.write_every_s
            run.step(round(amplitude_V * math.sin(self.phase_rad(middle_s)), 6), self.write_every_s)
        return run.finish()

    def phase_rad(self, time_s: float) -> float:
        """Return the sine's phase: 2 pi times the integral of f(t) = f0 (f1/f0)^(t/T)."""
        ratio = math.log(self.end_hz / self.start_hz)
        if ratio == 0.0:
            return 2 * math.pi * self.start_hz * time_s
        grown = math.expm1(ratio * time_s / self.duration_s)
        return 2 * math.pi * self.start_hz * self.duration_s / ratio * grown


EXTRA = Chirp
