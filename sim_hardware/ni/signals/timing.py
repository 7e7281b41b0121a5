"""Sample timing: as a client asked for it, and as the board coerces it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

from sim_hardware.ni.boards.contract import AnalogInputs, AnalogOutputs
from sim_hardware.ni.errors import Code, StatusError


class TimingType(IntEnum):
    """nidaqmx.constants.SampleTimingType."""

    SAMPLE_CLOCK = 10388
    ON_DEMAND = 10390


class SampleMode(IntEnum):
    """nidaqmx.constants.AcquisitionType."""

    FINITE = 10178
    CONTINUOUS = 10123
    HARDWARE_TIMED_SINGLE_POINT = 12522


RISING, FALLING = 10280, 10171
LINES_TIMEBASE_HZ, LINES_MAX_RATE_HZ = 100e6, 10e6


@dataclass(kw_only=True)
class TaskTiming:
    """As configured; nothing is checked before `plan`."""

    kind: TimingType = TimingType.ON_DEMAND
    rate_hz: float = 1000.0
    source: str = ""
    edge: int = RISING
    mode: SampleMode = SampleMode.FINITE
    samples: int = 1000
    buffer: int | None = None  # as set by the client; None: the driver chooses
    convert_rate_hz: float | None = None
    reference_clock: str = ""  # that the board's oscillator is locked to
    reference_clock_hz: float = 10e6

    def buffer_size(self, *, starts_again: bool = False) -> int:
        """Return the samples per channel that the driver keeps in the computer's memory.

        A task that each trigger starts again (`starts_again`) has that of one without an end.
        """
        if self.kind is TimingType.ON_DEMAND:
            return 0
        if self.buffer is not None:
            return self.buffer
        if self.mode is SampleMode.FINITE and not starts_again:
            return self.samples
        return max(self.samples, _default_buffer(self.rate_hz))


@dataclass(frozen=True)
class InputPlan:
    """The timing of an acquisition, checked and coerced."""

    rate_hz: float
    convert_s: float  # from one channel's conversion to the next one's; 0: simultaneous
    total: int | None  # samples of a finite acquisition
    buffer: int


def plan_input(timing: TaskTiming, side: AnalogInputs, channels: int) -> InputPlan:
    """Check a sample clock against the board, as the driver does at verify (-200077, -200081)."""
    _check_mode(timing)
    rate_hz = _coerced(timing.rate_hz, side.timebase_hz, side.min_rate_hz, side.max_rate(channels))
    convert_s = _convert_period(timing.convert_rate_hz, side, channels, rate_hz)
    return InputPlan(
        rate_hz=rate_hz,
        convert_s=convert_s,
        total=timing.samples if timing.mode is SampleMode.FINITE else None,
        buffer=timing.buffer_size(),
    )


def plan_lines(timing: TaskTiming) -> InputPlan:
    """Check a sample clock for lines that the board can time: X Series boards have such ports."""
    _check_mode(timing)
    least_hz = LINES_TIMEBASE_HZ / 2**32
    return InputPlan(
        rate_hz=_coerced(timing.rate_hz, LINES_TIMEBASE_HZ, least_hz, LINES_MAX_RATE_HZ),
        convert_s=0.0,
        total=timing.samples if timing.mode is SampleMode.FINITE else None,
        buffer=timing.buffer_size(),
    )


@dataclass(frozen=True)
class OutputPlan:
    """The timing of a generation, checked and coerced."""

    rate_hz: float
    total: int | None  # samples of a finite generation


def plan_output(timing: TaskTiming, side: AnalogOutputs) -> OutputPlan:
    """Check a sample clock against the outputs of a board that has one (-200077)."""
    assert side.max_rate_hz is not None  # noqa: S101 - `conformance` refuses such a board
    _check_mode(timing)
    least_hz = side.timebase_hz / 2**32
    rate_hz = _coerced(timing.rate_hz, side.timebase_hz, least_hz, side.max_rate_hz)
    return OutputPlan(rate_hz, timing.samples if timing.mode is SampleMode.FINITE else None)


def _check_mode(timing: TaskTiming) -> None:
    if timing.mode is SampleMode.HARDWARE_TIMED_SINGLE_POINT:
        raise StatusError(
            Code.INVALID_VALUE, "Property: DAQmx_SampQuant_SampMode\nHW Timed Single Point"
        )
    if timing.samples < 1 or (timing.mode is SampleMode.FINITE and timing.samples < 2):
        raise StatusError(
            Code.INVALID_VALUE,
            f"Property: DAQmx_SampQuant_SampPerChan\nRequested: {timing.samples}",
        )


def _coerced(asked_hz: float, timebase_hz: float, least_hz: float, most_hz: float) -> float:
    """Return the rate next above `asked_hz` that divides the timebase; -200077 out of limits."""
    if not least_hz <= asked_hz <= most_hz * (1 + 1e-9):
        raise StatusError(
            Code.INVALID_VALUE,
            f"Property: DAQmx_SampClk_Rate\nRequested Value: {asked_hz:g}\n"
            f"Maximum Value: {most_hz:g}\nMinimum Value: {least_hz:g}",
        )
    return timebase_hz / max(1, math.floor(timebase_hz / asked_hz * (1 + 1e-12)))


def _convert_period(
    asked_hz: float | None, side: AnalogInputs, channels: int, rate_hz: float
) -> float:
    if side.simultaneous:
        return 0.0
    if asked_hz is None:
        return min(side.min_convert_s + side.settling_s, 1.0 / (rate_hz * channels))
    if not 0 < asked_hz <= side.max_multi_rate_hz * (1 + 1e-9):
        raise StatusError(
            Code.INVALID_VALUE, f"Property: DAQmx_AIConv_Rate\nRequested: {asked_hz:g}"
        )
    if channels * rate_hz > asked_hz * (1 + 1e-9):
        raise StatusError(Code.RATE_AND_CHANNELS)
    return 1.0 / asked_hz


def _default_buffer(rate_hz: float) -> int:
    if rate_hz <= 100:
        return 1_000
    if rate_hz <= 10_000:
        return 10_000
    return 100_000 if rate_hz <= 1_000_000 else 1_000_000
