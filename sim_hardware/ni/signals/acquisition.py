"""A running acquisition: which samples have been acquired by now, and their values.

Nothing runs in the background. The time determines which samples have been acquired; their values
are computed by the simulated rig when a client reads them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim_hardware.ni.errors import Code, StatusError
from sim_hardware.ni.signals.adc import Converter, FloatArray
from sim_hardware.ni.signals.timing import InputPlan
from sim_hardware.ni.tasks.channels import AnalogInputChannel
from sim_hardware.simulated_rig import AnalogSide

_TINY = 1e-6  # of a sample period: a sample due exactly now is acquired


@dataclass(frozen=True)
class Samples:
    """Samples as codes, one row for each channel."""

    codes: npt.NDArray[np.int16]
    volts: FloatArray


class Sampler:
    """Acquires samples of a task's channels at given times."""

    def __init__(
        self,
        rig: AnalogSide,
        channels: Sequence[AnalogInputChannel],
        converters: Sequence[Converter],
    ) -> None:
        self._rig = rig
        self._channels = tuple(channels)
        self._converters = tuple(converters)

    def sample(self, times_s: FloatArray, convert_s: float, latest_s: float) -> Samples:
        """Return samples at `times_s`; each channel is converted `convert_s` after the last one.

        No sample is acquired after `latest_s`: rounding must not reach into the future.
        """
        shape = (len(self._channels), len(times_s))
        when = times_s + convert_s * np.arange(shape[0])[:, None]
        np.minimum(when, latest_s, out=when)
        raw = self._terminals(when)
        codes = np.empty(shape, np.int16)
        volts = np.empty(shape)
        for row, converter in enumerate(self._converters):
            codes[row] = converter.codes(raw[row])
            volts[row] = converter.volts(codes[row])
        return Samples(codes, volts)

    def _terminals(self, when: FloatArray) -> FloatArray:
        """Return the rig's volts. A terminal that occurs twice is read in the order of time."""
        raw = np.empty(when.shape)
        rows: dict[tuple[str, str], list[int]] = {}
        for row, channel in enumerate(self._channels):
            rows.setdefault((channel.device.name, channel.physical), []).append(row)
        for (device, physical), places in rows.items():
            times = when[places].ravel()
            order = np.argsort(times, kind="stable") if len(places) > 1 else slice(None)
            answer = np.empty(times.shape)
            answer[order] = self._rig.read(device, physical, times[order])
            raw[places] = answer.reshape(len(places), -1)
        return raw


class Acquisition:
    """A hardware-timed acquisition from its start on."""

    def __init__(self, plan: InputPlan, sampler: Sampler, channels: int, start_s: float) -> None:
        self.plan = plan
        self.start_s = start_s
        self.position = 0  # samples per channel that have been read
        self.overflowed = False
        self._sampler = sampler
        self._last_channel_s = (channels - 1) * plan.convert_s
        self._stopped_at: int | None = None

    def acquired(self, now_s: float) -> int:
        """Return the samples per channel acquired so far."""
        if self._stopped_at is not None:
            return self._stopped_at
        periods = (now_s - self.start_s - self._last_channel_s) * self.plan.rate_hz
        count = max(0, math.floor(periods + 1 + _TINY))
        return count if self.plan.total is None else min(count, self.plan.total)

    def time_of(self, count: int) -> float:
        """Return when `count` samples of every channel have been acquired."""
        return self.start_s + self._last_channel_s + (count - 1) / self.plan.rate_hz

    def available(self, now_s: float) -> int:
        """Return the samples per channel to be read; -200279 once unread ones were overwritten."""
        unread = self.acquired(now_s) - self.position
        if self.overflowed or (self.plan.total is None and unread > self.plan.buffer):
            self.overflowed = True
            raise StatusError(
                Code.OVERWRITTEN,
                f"Samples unread: {unread}\nBuffer size: {self.plan.buffer}",
                samples_read=0,
            )
        return unread

    def overflow_s(self) -> float:
        """Return when the buffer overflows if no client reads."""
        return self.time_of(self.position + self.plan.buffer + 1)

    def is_done(self, now_s: float) -> bool:
        """Return whether a finite acquisition has all its samples, or has been stopped."""
        total = self.plan.total
        return self._stopped_at is not None or (total is not None and self.acquired(now_s) >= total)

    def end(self, now_s: float) -> None:
        """Acquire no more samples."""
        self._stopped_at = self.acquired(now_s)

    def read(self, count: int, now_s: float) -> Samples:
        """Return the next `count` samples, which must have been acquired."""
        index = np.arange(self.position, self.position + count)
        times_s = self.start_s + index / self.plan.rate_hz
        self.position += count
        return self._sampler.sample(times_s, self.plan.convert_s, now_s)
