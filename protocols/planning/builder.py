"""Build the steps and readings of one run, and check that they fit into it."""

from __future__ import annotations

from protocols.errors import ScheduleError
from protocols.planning.schedule import PlannedReading, ReadingKind, VoltageStep

# Times are sums of decimal fractions; a nanosecond is far below what any board can do, and so is a
# nanovolt. What is the same at each period of a waveform would else be another voltage each time.
DECIMALS = 9

# Repeats of a reading shall not share samples of the filter's window with each other.
LARGEST_HALF_WINDOW_S = 0.02

# More readings than this in one step are a slip of the pen; the raw signals are recorded anyway.
MAX_READINGS_IN_STEP = 10_000

# A session of so many steps and readings would take most of a day at the rig.
MAX_STEPS_AND_READINGS = 100_000

# Steps, readings and duration (s) of one run.
StepsAndReadings = tuple[tuple[VoltageStep, ...], tuple[PlannedReading, ...], float]


class Builder:
    """Put steps one after another and count readings."""

    def __init__(self) -> None:
        self._steps: list[VoltageStep] = []
        self._readings: list[PlannedReading] = []
        self._end_s = 0.0

    def step(self, voltage_V: float, lasts_s: float) -> None:
        """Hold a voltage for a time, after all that has been added before."""
        # adding zero makes 0 V of -0 V
        self._steps.append(VoltageStep(self._end_s, round(voltage_V, DECIMALS) + 0.0))
        self._end_s = round(self._end_s + lasts_s, DECIMALS)
        require_size(len(self._steps) + len(self._readings))

    def reading(self, delay_s: float, half_window_s: float, kind: ReadingKind) -> None:
        """Take a reading in the step added last. Raises ScheduleError where there is none."""
        if not self._steps:
            raise ScheduleError("a reading comes before the first step; add the step first")
        step = len(self._steps) - 1
        self._readings.append(
            PlannedReading(
                index=len(self._readings),
                step=step,
                delay_s=round(delay_s, DECIMALS),
                half_window_s=half_window_s,
                voltage_V=self._steps[step].voltage_V,
                kind=kind,
            )
        )
        require_size(len(self._steps) + len(self._readings))

    def readings_every(self, every_s: float, lasts_s: float, kind: ReadingKind) -> None:
        """Take readings at every multiple of `every_s` whose window fits into the last step."""
        if lasts_s / every_s > MAX_READINGS_IN_STEP:
            raise ScheduleError(
                f"sample_every_s = {every_s:g} s makes more than {MAX_READINGS_IN_STEP} "
                f"readings in {lasts_s:g} s; the raw signals are recorded at the full rate anyway"
            )
        half_window_s = min(every_s / 2, LARGEST_HALF_WINDOW_S)
        count = 1
        while fits(count * every_s + half_window_s, lasts_s):
            self.reading(count * every_s, half_window_s, kind)
            count += 1

    def finish(self) -> StepsAndReadings:
        """Return to 0 V, unless that is where the last step is, and hand over everything.

        Raises ScheduleError where there is no step.
        """
        if not self._steps:
            raise ScheduleError("it has no step")
        if self._steps[-1].voltage_V != 0.0:
            self.step(0.0, 0.0)
        return tuple(self._steps), tuple(self._readings), self._end_s


def require_size(count: int) -> None:
    """Raise ScheduleError when there are too many steps and readings to be meant."""
    if count > MAX_STEPS_AND_READINGS:
        raise ScheduleError(
            f"there are more than {MAX_STEPS_AND_READINGS} steps and readings; ask for fewer "
            "voltages, readings, positions or cycles"
        )


def fits(time_s: float, into_s: float) -> bool:
    """Whether one time is within another, up to rounding."""
    return time_s <= into_s + 10.0**-DECIMALS


def require_window(sample_at_s: float, half_window_s: float, lasts_s: float, lasts: str) -> None:
    """Raise ScheduleError unless sample_at_s ± half_window_s lies between 0 and `lasts_s`."""
    if not (fits(half_window_s, sample_at_s) and fits(sample_at_s + half_window_s, lasts_s)):
        raise ScheduleError(
            f"sample_at_s ± half_window_s = {sample_at_s:g} ± {half_window_s:g} s must lie "
            f"between 0 and {lasts} = {lasts_s:g} s"
        )


def require_kept(parts: StepsAndReadings, hold_s: float, sample_every_s: float) -> None:
    """Raise ScheduleError unless at least one reading is kept."""
    if not any(reading.kind is ReadingKind.KEPT for reading in parts[1]):
        raise ScheduleError(
            f"no reading fits into hold_s = {hold_s:g} s; "
            f"make sample_every_s = {sample_every_s:g} s smaller"
        )
