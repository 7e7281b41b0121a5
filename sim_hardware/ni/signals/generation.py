"""A clocked output: the samples in its buffer, and which of them have been put out by now.

Nothing runs in the background. The time determines how far a generation is; the engine passes its
changes on to the rig, in the order of time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from sim_hardware.ni.errors import Code, StatusError
from sim_hardware.ni.signals.adc import FloatArray
from sim_hardware.ni.signals.timebase import Timebase
from sim_hardware.ni.signals.timing import OutputPlan

FIRST_SAMPLE, CURRENT_WRITE_POSITION = 10424, 10430  # constants.WriteRelativeTo
ALLOW_REGENERATION, DONT_ALLOW_REGENERATION = 10097, 10158  # constants.RegenerationMode


@dataclass(kw_only=True)
class OutputBuffer:
    """Samples in the computer's memory, written in a ring; it outlives a stop."""

    size: int | None = None  # as set by the client; None: as many as are written first
    regeneration: int = ALLOW_REGENERATION
    relative_to: int = CURRENT_WRITE_POSITION
    offset: int = 0
    written: int = 0  # samples per channel, up to the furthest one
    next: int = 0  # where the next write begins
    ring: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def regenerates(self) -> bool:
        """Whether old samples are put out again where no new ones come."""
        return self.regeneration == ALLOW_REGENERATION

    @property
    def length(self) -> int:
        """Samples per channel that it holds."""
        return int(self.ring.shape[1])

    def clear(self) -> None:
        """Forget the samples."""
        self.written = self.next = 0
        self.ring = np.zeros((0, 0))

    def position(self, generated: int) -> int:
        """Return where a write begins: -200287, -200289 where it may not."""
        base = 0 if self.relative_to == FIRST_SAMPLE else self.next
        found = base + self.offset
        if found < 0:
            raise StatusError(Code.NEGATIVE_WRITE_SAMPLE, samples_written=0)
        if found < generated and not self.regenerates:
            raise StatusError(Code.NO_LONGER_WRITEABLE, samples_written=0)
        return found

    def put(self, position: int, values: FloatArray) -> None:
        """Write samples (channels, samples) from a position on."""
        if self.length == 0:
            self.ring = np.zeros((values.shape[0], self.size or values.shape[1]))
        places = (position + np.arange(values.shape[1])) % self.length
        self.ring[:, places] = values
        self.next = position + values.shape[1]
        self.written = max(self.written, self.next)

    def between(self, first: int, end: int) -> FloatArray:
        """Return the samples that are put out as number `first` to before `end`."""
        used = self.length if self.written >= self.length else max(1, self.written)
        return self.ring[:, np.arange(first, end) % used]


class Generation:
    """A running generation."""

    def __init__(self, plan: OutputPlan, buffer: OutputBuffer, timebase: Timebase) -> None:
        self.plan = plan
        self.buffer = buffer
        self.timebase = timebase
        self.underflowed = False
        self.failed: int | None = None  # the status that a fault of the board has ended it with
        self._base = 0  # samples put out before this timebase
        self._skipped = 0
        self._passed_on = 0
        self._last: FloatArray | None = None

    def follow(self, timebase: Timebase, skipped: int) -> None:
        """Be clocked by another timebase from now on, of which some edges have passed."""
        self._base, self._skipped = self._passed_on, skipped
        self.timebase = timebase

    def generated(self, now_s: float) -> int:
        """Return the samples per channel put out so far."""
        if self.underflowed or self.failed is not None:
            return self._passed_on
        count = self._base + max(0, self.timebase.edges(now_s) - self._skipped)
        return min(count, self._most())

    def _most(self) -> int:
        """Return how many samples it can put out with what has been written."""
        most: float = math.inf if self.plan.total is None else self.plan.total
        return int(min(most, 2**62 if self.buffer.regenerates else self.buffer.written))

    def time_of(self, count: int) -> float:
        """Return when `count` samples have been put out."""
        return self.timebase.time_of(count - 1 - self._base + self._skipped)

    def overflow_s(self) -> float:
        """Return when it runs out of samples, if no client writes."""
        total = self.plan.total
        if self.buffer.regenerates or (total is not None and self.buffer.written >= total):
            return math.inf
        return self.time_of(self.buffer.written + 1)

    def is_done(self, now_s: float) -> bool:
        """Return whether a finite generation has put out all; -200290 once it ran out of them."""
        self.check(now_s)
        return self.plan.total is not None and self.generated(now_s) >= self.plan.total

    def check(self, now_s: float) -> None:
        """Raise what has ended the generation before its time."""
        if self.failed is not None:
            raise StatusError(self.failed, samples_written=0)
        if self.underflowed or now_s >= self.overflow_s():
            self.underflowed = True
            raise StatusError(Code.GENERATION_UNDERFLOW, samples_written=0)

    def changes(self, now_s: float) -> Iterator[tuple[float, int, float]]:
        """Yield time, channel and volts of each change up to now that was not yielded yet."""
        until = self.generated(now_s)
        if until == self._passed_on:
            return
        first, self._passed_on = self._passed_on, until
        rows = self.buffer.between(first, until)
        before = np.full((rows.shape[0], 1), np.nan) if self._last is None else self._last
        changed = np.diff(np.hstack([before, rows]), axis=1) != 0.0  # NaN: the first sample
        self._last = rows[:, -1:]
        for sample in np.flatnonzero(changed.any(axis=0)):
            when_s = self.time_of(first + int(sample) + 1)
            for channel in np.flatnonzero(changed[:, sample]):
                yield min(when_s, now_s), int(channel), float(rows[channel, sample])

    def next_change_s(self, now_s: float, look_ahead: int = 10_000) -> float:
        """Return when the output changes next, or to look again; inf: never."""
        end = min(self._passed_on + look_ahead, self._most())
        if end <= self._passed_on or self._last is None:
            return self.time_of(self._passed_on + 1) if end > self._passed_on else math.inf
        rows = np.hstack([self._last, self.buffer.between(self._passed_on, end)])
        changed = np.flatnonzero((np.diff(rows, axis=1) != 0.0).any(axis=0))
        ahead = int(changed[0]) + 1 if changed.size else end - self._passed_on
        return max(now_s, self.time_of(self._passed_on + ahead))
