"""Readings at 0 V, then pulses of voltages in turn, one reading in each."""

from __future__ import annotations

from dataclasses import dataclass, replace

from protocols.planning.builder import Builder, StepsAndReadings
from protocols.planning.schedule import ReadingKind


@dataclass(frozen=True, kw_only=True)
class Pulses:
    """A row of pulses of equal length, after as many readings at 0 V as are wanted.

    Planning uses it for what it adds to a protocol: the load cell's zero and the free shapes.
    """

    voltages_V: tuple[float, ...]
    zero_readings: int
    pulses_discarded: int  # recorded and marked
    readings_per_voltage: int
    pulse_s: float
    sample_at_s: float  # after the edge, as written
    half_window_s: float
    rest_s: float  # at 0 V after each pulse

    @property
    def count(self) -> int:
        """Number of all pulses, the discarded ones too."""
        return self.pulses_discarded + self.readings_per_voltage * len(self.voltages_V)

    def steps_and_readings(self) -> StepsAndReadings:
        """Return the steps, the readings and the duration (s); ends at 0 V."""
        run = Builder()
        self._add_zero_readings(run, self.zero_readings, ReadingKind.ZERO)
        self.add_to(run)
        return run.finish()

    def with_readings(self, per_voltage: int) -> Pulses:
        """Return the same pulses with another number of readings at each voltage."""
        return replace(self, readings_per_voltage=per_voltage)

    def add_to(self, run: Builder) -> None:
        """Add the pulses alone to a run."""
        for pulse in range(self.count):
            run.step(self.voltages_V[pulse % len(self.voltages_V)], self.pulse_s)
            kept = pulse >= self.pulses_discarded
            kind = ReadingKind.KEPT if kept else ReadingKind.DISCARDED
            run.reading(self.sample_at_s, self.half_window_s, kind)
            if self.rest_s:
                run.step(0.0, self.rest_s)

    def zero_of_load_cell(self, count: int) -> StepsAndReadings:
        """Return `count` readings at 0 V of a load cell that nothing touches."""
        run = Builder()
        self._add_zero_readings(run, count, ReadingKind.NO_CONTACT)
        return run.finish()

    def _add_zero_readings(self, run: Builder, count: int, kind: ReadingKind) -> None:
        if count:
            run.step(0.0, count * self.pulse_s)
        for slot in range(count):
            run.reading(slot * self.pulse_s + self.sample_at_s, self.half_window_s, kind)
