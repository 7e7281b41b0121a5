"""Readings at 0 V, then pulses of alternating voltages: the paper's protocol."""

from __future__ import annotations

from dataclasses import dataclass

from protocols.errors import ScheduleError, require_count, require_number
from protocols.kinds.definition import Builder, StepsAndReadings, require_window
from protocols.planning.schedule import ReadingKind


@dataclass(frozen=True)
class PulseTrain:
    """Zero readings, one a slot of `pulse_s`, then one reading a pulse; voltages take turns.

    The first `pulses_discarded` pulses are recorded and marked; so many follow that every voltage
    is read `readings_per_voltage` times.
    """

    voltages_V: tuple[float, ...] = (2.0, -2.0)
    zero_readings: int = 10
    pulses_discarded: int = 2
    readings_per_voltage: int = 10
    pulse_s: float = 0.6
    sample_at_s: float = 0.5  # after the edge, as written
    half_window_s: float = 0.1  # the filter's reach on either side
    rest_s: float = 0.0  # at 0 V after each pulse

    def __post_init__(self) -> None:
        what = self.name
        if not self.voltages_V:
            raise ScheduleError(f"{what}: voltages_V is empty")
        for voltage_V in self.voltages_V:
            require_number(f"{what}: a voltage", voltage_V)
        require_count(f"{what}: zero_readings", self.zero_readings, least=0)
        require_count(f"{what}: pulses_discarded", self.pulses_discarded, least=0)
        require_count(f"{what}: readings_per_voltage", self.readings_per_voltage, least=1)
        require_number(f"{what}: pulse_s", self.pulse_s, above=0.0)
        require_number(f"{what}: sample_at_s", self.sample_at_s, above=0.0)
        require_number(f"{what}: half_window_s", self.half_window_s, above=0.0)
        require_number(f"{what}: rest_s", self.rest_s)
        if self.rest_s < 0:
            raise ScheduleError(f"{what}: rest_s = {self.rest_s:g} must not be negative")
        require_window(what, self.sample_at_s, self.half_window_s, self.pulse_s, "pulse_s")
        self._require_edges()

    @property
    def name(self) -> str:
        """See `Definition.name`."""
        return "pulse_train"

    @property
    def pulses(self) -> int:
        """All pulses, the discarded ones too."""
        return self.pulses_discarded + self.readings_per_voltage * len(self.voltages_V)

    def steps_and_readings(self) -> StepsAndReadings:
        """See `Definition.steps_and_readings`."""
        run = Builder()
        if self.zero_readings:
            run.step(0.0, self.zero_readings * self.pulse_s)
        for slot in range(self.zero_readings):
            delay_s = slot * self.pulse_s + self.sample_at_s
            run.reading(delay_s, self.half_window_s, ReadingKind.ZERO)
        for pulse in range(self.pulses):
            run.step(self.voltages_V[pulse % len(self.voltages_V)], self.pulse_s)
            kept = pulse >= self.pulses_discarded
            kind = ReadingKind.KEPT if kept else ReadingKind.DISCARDED
            run.reading(self.sample_at_s, self.half_window_s, kind)
            if self.rest_s:
                run.step(0.0, self.rest_s)
        return run.finish()

    def _require_edges(self) -> None:
        """A pulse needs an edge at its start; without one it has no sampling point."""
        following = self.voltages_V[1:] + self.voltages_V[:1]
        for voltage_V, after_V in zip(self.voltages_V, following, strict=True):
            if self.rest_s == 0 and voltage_V == after_V:
                raise ScheduleError(
                    f"{self.name}: {voltage_V:g} V follows {voltage_V:g} V without an edge between "
                    "them; set rest_s or change voltages_V"
                )
