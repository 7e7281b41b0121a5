"""A sample clock: when its edges come, by the simulated board's own oscillator."""

from __future__ import annotations

import math
from dataclasses import dataclass

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
