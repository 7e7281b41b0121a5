"""A running acquisition: which samples have been acquired by now, and their values.

Nothing runs in the background. The time determines which samples have been acquired; their values
are computed by the simulated rig when a client reads them.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from sim_hardware.ni.errors import Code, StatusError
from sim_hardware.ni.signals.adc import Converter, FloatArray
from sim_hardware.ni.signals.shown_signals import LimitSine
from sim_hardware.ni.signals.timebase import Timebase
from sim_hardware.ni.signals.timing import InputPlan
from sim_hardware.ni.tasks.channels import AnalogInputChannel
from sim_hardware.simulated_rig import AnalogSide

# constants.ReadRelativeTo, OverwriteMode
FIRST_SAMPLE, CURRENT_READ_POSITION, MOST_RECENT_SAMPLE = 10424, 10425, 10428
REFERENCE_TRIGGER, FIRST_PRETRIGGER_SAMPLE = 10426, 10427
OVERWRITE, DO_NOT_OVERWRITE = 10252, 10159


@dataclass(frozen=True)
class Samples:
    """Samples as codes, one row for each channel; of digital channels, as words."""

    codes: npt.NDArray[np.integer]
    volts: FloatArray


class SampleSource(Protocol):
    """What samples a task's channels."""

    def sample(self, times_s: FloatArray, convert_s: float, latest_s: float) -> Samples:
        """Return samples at `times_s`, none after `latest_s`."""


class Sampler:
    """Acquires samples of a task's channels at given times."""

    def __init__(
        self,
        rig: AnalogSide,
        channels: Sequence[AnalogInputChannel],
        converters: Sequence[Converter],
        shown: Sequence[LimitSine | None],
    ) -> None:
        """`shown`: for each channel what it shows in place of the rig's volts, if anything."""
        self._rig = rig
        self._shown = tuple(shown)
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
        for row, sine in enumerate(self._shown):
            if sine is not None:
                raw[row] = sine.volts(when[row])
        return raw


@dataclass
class ReadPosition:
    """Where a read begins, as the client has set it; it outlives a stop."""

    relative_to: int = CURRENT_READ_POSITION
    offset: int = 0
    overwrite: int = DO_NOT_OVERWRITE


class Acquisition:
    """A hardware-timed acquisition from its start on."""

    def __init__(
        self,
        plan: InputPlan,
        sampler: SampleSource,
        channels: int,
        timebase: Timebase,
        reads: ReadPosition,
    ) -> None:
        self.plan = plan
        self.timebase = timebase
        self.position = 0  # the sample per channel after the last one that was read
        self.overflowed = False
        self._skipped = 0  # edges of the timebase that had passed at the start
        self._sampler = sampler
        self._reads = reads
        self._last_channel_s = (channels - 1) * plan.convert_s
        self._stopped_at: int | None = None
        # What has been read, as long as it is in the buffer: it may be read again.
        self._recent: deque[tuple[int, Samples]] = deque()
        self._sampled = 0  # samples of every channel that have been computed

    def follow(self, timebase: Timebase, skipped: int) -> None:
        """Be clocked by another task's timebase, of which some edges have passed."""
        self.timebase, self._skipped = timebase, skipped

    def acquired(self, now_s: float) -> int:
        """Return the samples per channel acquired so far."""
        if self._stopped_at is not None:
            return self._stopped_at
        count, total = self._converted(now_s), self.total
        return count if total is None else min(count, total)

    @property
    def total(self) -> int | None:
        """Samples per channel after which it ends; None: it does not end, as it looks now."""
        return self.plan.total

    @property
    def left(self) -> int | None:
        """Samples per channel that remain to be read; None: without end."""
        total = self.total
        return None if total is None else total - self.position

    def _converted(self, now_s: float) -> int:
        """Return for how many samples the clock has come, whether they are kept or not."""
        return max(0, self.timebase.edges(now_s, self._last_channel_s) - self._skipped)

    def time_of(self, count: int) -> float:
        """Return when `count` samples of every channel have been acquired."""
        return self.timebase.time_of(self._skipped + count - 1) + self._last_channel_s

    def first(self, now_s: float) -> int:
        """Return the sample at which a read begins now. -200277: before the first one."""
        base = self._base(self._reads.relative_to, now_s)
        if base + self._reads.offset < 0:
            raise StatusError(Code.NEGATIVE_READ_SAMPLE, samples_read=0)
        return base + self._reads.offset

    def _base(self, relative_to: int, now_s: float) -> int:
        if relative_to in (REFERENCE_TRIGGER, FIRST_PRETRIGGER_SAMPLE):
            raise StatusError(Code.NO_REFERENCE_TRIGGER, samples_read=0)
        found = {FIRST_SAMPLE: 0, MOST_RECENT_SAMPLE: self.acquired(now_s)}
        return found.get(relative_to, self.position)

    def available(self, now_s: float) -> int:
        """Return the samples per channel to be read; -200279 once they were overwritten."""
        acquired = self.acquired(now_s)
        first = self.first(now_s)
        if self.overflows and acquired - self.position > self.plan.buffer:
            self.overflowed = True
        if self.overflowed or (self.plan.total is None and acquired - first > self.plan.buffer):
            raise StatusError(
                Code.OVERWRITTEN,
                f"Samples unread: {acquired - first}\nBuffer size: {self.plan.buffer}",
                samples_read=0,
            )
        return max(0, acquired - first)

    @property
    def overflows(self) -> bool:
        """Whether a full buffer ends it."""
        return self.plan.total is None and self._reads.overwrite == DO_NOT_OVERWRITE

    def overflow_s(self) -> float:
        """Return when the buffer overflows if no client reads; inf: never."""
        return self.time_of(self.position + self.plan.buffer + 1) if self.overflows else math.inf

    def is_done(self, now_s: float) -> bool:
        """Return whether a finite acquisition has all its samples, or has been stopped."""
        total = self.total
        return self._stopped_at is not None or (total is not None and self.acquired(now_s) >= total)

    def nominal_s(self, sample: int) -> float:
        """Return the time of a sample as if its clock had never paused: that of waveforms."""
        return self.timebase.start_s + (self._skipped + sample) / self.timebase.rate_hz

    def end(self, now_s: float) -> None:
        """Acquire no more samples."""
        self._stopped_at = self.acquired(now_s)

    def read(self, count: int, now_s: float) -> Samples:
        """Return `count` samples from where a read begins; they must have been acquired."""
        first = self.first(now_s)
        self.position = first + count
        if first < self._sampled:
            return self._again(first, count, now_s)
        return self._new(first, count, now_s)

    def _new(self, first: int, count: int, now_s: float) -> Samples:
        """Compute samples; those that were passed over are never computed."""
        times_s = self.timebase.times(self._skipped + np.arange(first, first + count))
        samples = self._sampler.sample(times_s, self.plan.convert_s, now_s)
        if first > self._sampled:
            self._recent.clear()  # there is a gap before them
        self._sampled = first + count
        self._recent.append((first, samples))
        while len(self._recent) > 1 and self._recent[1][0] <= self._sampled - self.plan.buffer:
            self._recent.popleft()
        return samples

    def _again(self, first: int, count: int, now_s: float) -> Samples:
        """Return samples of which at least the first has been read before."""
        if first + count > self._sampled:
            self._new(self._sampled, first + count - self._sampled, now_s)
        if self._recent[0][0] > first:
            raise StatusError(Code.OVERWRITTEN, samples_read=0)
        start, blocks = self._recent[0][0], [block for _, block in self._recent]
        places = slice(first - start, first - start + count)
        codes = np.hstack([block.codes for block in blocks])[:, places]
        return Samples(codes, np.hstack([block.volts for block in blocks])[:, places])
