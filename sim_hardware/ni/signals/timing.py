"""Sample timing: as a client asked for it, and as the board coerces it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

from sim_hardware.ni.boards.contract import AnalogInputs
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

    def buffer_size(self) -> int:
        """Return the samples per channel that the driver keeps in the computer's memory."""
        if self.kind is TimingType.ON_DEMAND:
            return 0
        if self.buffer is not None:
            return self.buffer
        if self.mode is SampleMode.FINITE:
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
    if timing.mode is SampleMode.HARDWARE_TIMED_SINGLE_POINT:
        raise StatusError(
            Code.INVALID_VALUE, "Property: DAQmx_SampQuant_SampMode\nHW Timed Single Point"
        )
    if timing.samples < 1 or (timing.mode is SampleMode.FINITE and timing.samples < 2):
        raise StatusError(
            Code.INVALID_VALUE,
            f"Property: DAQmx_SampQuant_SampPerChan\nRequested: {timing.samples}",
        )
    if timing.source not in ("", "OnboardClock"):
        raise StatusError(
            Code.INVALID_VALUE, f"Property: DAQmx_SampClk_Src\nRequested: {timing.source}"
        )
    rate_hz = coerced_rate(timing.rate_hz, side, channels)
    convert_s = _convert_period(timing.convert_rate_hz, side, channels, rate_hz)
    return InputPlan(
        rate_hz=rate_hz,
        convert_s=convert_s,
        total=timing.samples if timing.mode is SampleMode.FINITE else None,
        buffer=timing.buffer_size(),
    )


def coerced_rate(asked_hz: float, side: AnalogInputs, channels: int) -> float:
    """Return the rate next above `asked_hz` that divides the timebase; -200077 out of limits."""
    most = side.max_rate(channels)
    if not side.min_rate_hz <= asked_hz <= most * (1 + 1e-9):
        raise StatusError(
            Code.INVALID_VALUE,
            f"Property: DAQmx_SampClk_Rate\nRequested Value: {asked_hz:g}\n"
            f"Maximum Value: {most:g}\nMinimum Value: {side.min_rate_hz:g}",
        )
    return side.timebase_hz / max(1, math.floor(side.timebase_hz / asked_hz * (1 + 1e-12)))


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
