"""Sampled signals, and a meter that reads the force by itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

# Between two values of a force sensor that is asked for one at a time. Windows of protocols are
# 0.2 s, and the force between two values is a straight line: further apart, it shows no pulse.
FORCE_GAP_S = 0.25


@dataclass(frozen=True)
class SignalBlock:
    """Consecutive samples of all channels. `volts` has shape (channels, samples)."""

    first_index: int  # index of the first sample since the acquisition's start
    volts: FloatArray
    read_s: float  # clock time when the block had arrived


@dataclass(frozen=True)
class SampleClock:
    """Sample indices against clock time: sample i was acquired at start_s + i / rate_hz."""

    start_s: float  # clock time of sample 0
    start_uncertainty_s: float  # half the time the start request took
    rate_hz: float  # the rate the device achieved, which is seldom quite the one asked for

    def time_of(self, index: float) -> float:
        """Clock time of a sample index (a fraction counts)."""
        return self.start_s + index / self.rate_hz

    def index_at(self, time_s: float) -> float:
        """Sample index, with its fraction, at a clock time."""
        return (time_s - self.start_s) * self.rate_hz


@runtime_checkable
class SignalInput(Protocol):
    """Hardware-timed, continuous acquisition of named channels."""

    @property
    def channels(self) -> Sequence[str]:
        """Names of the channels in the order of the blocks' rows, such as force, current, drive."""

    @property
    def ranges_V(self) -> Sequence[float]:
        """The device's actual input range (either sign) of each channel."""

    @property
    def rate_hz(self) -> float:
        """Samples per second and channel that the device achieves (after `open`)."""

    def open(self) -> None:
        """Take the device and configure it. Raises DeviceNotFoundError, DeviceError."""

    def start(self) -> SampleClock:
        """Begin to acquire, from sample 0."""

    def read_available(self) -> SignalBlock:
        """All samples that have arrived since the last read (perhaps none); does not wait for more.

        Raises LostSamplesError when samples were overwritten, DeviceTimeoutError, DeviceError.
        """

    def stop(self) -> None:
        """Stop acquiring; may be called when not started."""

    def measure(self, duration_s: float) -> FloatArray:
        """Acquire for `duration_s` and return all samples (channels, samples), acquisition stopped.

        For preflight and read-back; must not be called between `start` and `stop`.
        """

    def close(self) -> None:
        """Let go of the device. May be called twice."""


@runtime_checkable
class InterpolatedForce(Protocol):
    """A `SignalInput` whose force is a line between values that come more seldom than samples."""

    def force_times_s(self, begin_s: float, end_s: float) -> FloatArray:
        """Return the clock times of the values that make the force from `begin_s` to `end_s`.

        The last one before and the first one after are among them.
        """


@runtime_checkable
class ForceSensor(Protocol):
    """A sensor that is asked for one force at a time (a meter on a serial line).

    One thread opens it, another reads it, never two at the same time.
    """

    @property
    def range_N(self) -> float:
        """Largest force, either sign, that it can report."""

    def open(self) -> None:
        """Take the device; blocks for a few exchanges. Raises DeviceNotFoundError, DeviceError."""

    def read_force(self) -> float:
        """Return the force now, in N; blocks for one exchange, and at most for 2 s.

        A run asks again and again, and ends when no reading has come for 1 s.
        Raises OverloadError beyond its range, DeviceTimeoutError, DeviceError.
        """

    def tare(self) -> None:
        """Make the present load the zero; blocks for one exchange. Raises DeviceError."""

    def close(self) -> None:
        """Let go of the device. May be called twice."""
