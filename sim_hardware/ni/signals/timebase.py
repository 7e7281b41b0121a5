"""Sample clocks: when their edges come, by the simulated board's own oscillator."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

_TINY = 1e-6  # of a period: an edge due exactly now has come


@dataclass
class Timebase:
    """Edges at `start_s + k / rate_hz`. Shared by all tasks that are timed by one clock."""

    rate_hz: float  # on the computer's clock
    start_s: float = math.inf  # inf: it waits for its trigger
    stop_s: float = math.inf

    def edges(self, now_s: float, delay_s: float = 0.0) -> int:
        """Return how many edges were at least `delay_s` ago."""
        if self.start_s > now_s:
            return 0
        elapsed_s = min(now_s, self.stop_s) - self.start_s - delay_s
        return max(0, math.floor(elapsed_s * self.rate_hz + 1 + _TINY))

    def time_of(self, edge: int) -> float:
        """Return when an edge comes; inf: never, as it looks now."""
        when_s = self.start_s + edge / self.rate_hz
        return when_s if when_s <= self.stop_s else math.inf

    def times(self, edges: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
        """Return when edges came."""
        return self.start_s + edges / self.rate_hz


@dataclass
class RetriggeredTimebase(Timebase):
    """So many edges after each trigger; a trigger that comes before the last of them is ignored."""

    samples: int = field(kw_only=True)
    next_trigger: Callable[[float], float] = field(kw_only=True)  # the first one after a time
    _begins_s: list[float] = field(default_factory=list)

    def edges(self, now_s: float, delay_s: float = 0.0) -> int:
        """See `Timebase.edges`."""
        until_s = min(now_s, self.stop_s) - delay_s
        begun = 0
        while self._begin(begun) <= until_s:
            begun += 1
        if begun == 0:
            return 0
        since_s = until_s - self._begins_s[begun - 1]
        last = min(self.samples, math.floor(since_s * self.rate_hz + 1 + _TINY))
        return (begun - 1) * self.samples + last

    def time_of(self, edge: int) -> float:
        """See `Timebase.time_of`."""
        number, within = divmod(edge, self.samples)
        when_s = self._begin(number) + within / self.rate_hz
        return when_s if when_s <= self.stop_s else math.inf

    def times(self, edges: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
        """See `Timebase.times`."""
        number, within = np.divmod(edges, self.samples)
        begins_s = np.array([self._begin(each) for each in range(int(number.max(initial=0)) + 1)])
        return begins_s[number] + within / self.rate_hz

    def _begin(self, number: int) -> float:
        """Return when a trigger came that was not ignored; inf: never."""
        if not self._begins_s and not math.isinf(self.start_s):
            self._begins_s.append(self.start_s)
        while self._begins_s and len(self._begins_s) <= number:
            last_s = self._begins_s[-1] + (self.samples - 1) / self.rate_hz
            next_s = self.next_trigger(last_s)
            if math.isinf(next_s):
                break
            self._begins_s.append(next_s)
        return self._begins_s[number] if number < len(self._begins_s) else math.inf
