"""An acquisition that a reference trigger ends, with samples from before the trigger."""

from __future__ import annotations

import math
from collections.abc import Callable

from sim_hardware.ni.errors import Code, StatusError
from sim_hardware.ni.signals.acquisition import (
    CURRENT_READ_POSITION,
    FIRST_PRETRIGGER_SAMPLE,
    REFERENCE_TRIGGER,
    Acquisition,
    ReadPosition,
    Samples,
    SampleSource,
)
from sim_hardware.ni.signals.timebase import Timebase
from sim_hardware.ni.signals.timing import InputPlan

_TINY = 1e-6  # of a period: a sample at the very time of the trigger comes after it


class ReferencedAcquisition(Acquisition):
    """Samples go round in a buffer from the start on, until the trigger and those after it.

    A trigger that comes before all pretrigger samples is ignored. Reads begin at the first
    pretrigger sample, once all is there; relative to other samples, they may begin before.
    """

    def __init__(
        self,
        plan: InputPlan,
        sampler: SampleSource,
        channels: int,
        timebase: Timebase,
        reads: ReadPosition,
        *,
        pretrigger: int,
        next_edge: Callable[[float], float],
    ) -> None:
        """`next_edge`: when the next edge after a time comes at the trigger's terminal."""
        super().__init__(plan, sampler, channels, timebase, reads)
        self._pretrigger = pretrigger
        self._next_edge = next_edge
        self._trigger: int | None = None  # the first sample after the edge, once it is known
        self._begun = False  # whether the window has been read

    def _first_after(self) -> int | None:
        """Return the first sample after the trigger; None: none comes, as it looks now."""
        if self._trigger is None:
            ready_s = super().time_of(self._pretrigger)
            edge_s = math.inf if math.isinf(ready_s) else self._next_edge(ready_s)
            if math.isinf(edge_s):
                return None
            periods = (edge_s - self.timebase.start_s) * self.timebase.rate_hz
            self._trigger = math.ceil(periods - _TINY) - self._skipped
        return self._trigger

    @property
    def total(self) -> int | None:
        """See `Acquisition.total`: as soon as the trigger is known."""
        first, wanted = self._first_after(), self.plan.total
        return None if first is None or wanted is None else first - self._pretrigger + wanted

    @property
    def left(self) -> int | None:
        """See `Acquisition.left`: of the window about the trigger, where reads wait for it."""
        if not self._waits:
            return None
        return (self.plan.total or 0) - (self.position - self._window() if self._begun else 0)

    def _window(self) -> int:
        """Return the first pretrigger sample; 0 as long as it is not known."""
        first = self._first_after()
        return 0 if first is None else first - self._pretrigger

    @property
    def overflows(self) -> bool:
        """See `Acquisition.overflows`: old samples give way to new ones."""
        return False

    def available(self, now_s: float) -> int:
        """See `Acquisition.available`; nothing of the window before all of it is there."""
        acquired = self.acquired(now_s)
        if self._reads.relative_to == REFERENCE_TRIGGER and not self.is_done(now_s):
            raise StatusError(Code.REFERENCE_NOT_DONE, samples_read=0)
        if self._waits and not self.is_done(now_s):
            return 0
        first = self.first(now_s)
        if acquired - first > self.plan.buffer:
            raise StatusError(Code.OVERWRITTEN, samples_read=0)
        return max(0, acquired - first)

    @property
    def _waits(self) -> bool:
        """Whether reads wait for the whole window."""
        return self._reads.relative_to in (CURRENT_READ_POSITION, FIRST_PRETRIGGER_SAMPLE)

    def _base(self, relative_to: int, now_s: float) -> int:
        if relative_to == REFERENCE_TRIGGER:
            return self._window() + self._pretrigger
        if relative_to == FIRST_PRETRIGGER_SAMPLE:
            return self._window()
        if relative_to == CURRENT_READ_POSITION and not self._begun:
            return self._window()
        return super()._base(relative_to, now_s)

    def read(self, count: int, now_s: float) -> Samples:
        """See `Acquisition.read`. All of the window can be read again."""
        window = self._window()
        if self.is_done(now_s) and window >= self._sampled and self.plan.total is not None:
            self._new(window, self.plan.total, now_s)
        samples = super().read(count, now_s)
        self._begun = self._begun or count > 0
        return samples

    def time_of(self, count: int) -> float:
        """See `Acquisition.time_of`: while reads wait, that of the whole window."""
        total = self.total
        if not self._waits:
            return super().time_of(count)
        return math.inf if total is None else super().time_of(total)
