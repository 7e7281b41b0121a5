"""The interlock: what holds the relay in the amplifier's supply, edges or a level."""

from __future__ import annotations

import math


class SupplyRelay:
    """Closed by an edge for `hold_s`; each edge restarts that time."""

    def __init__(self, hold_s: float, *, closed: bool) -> None:
        """Set the time it holds; `closed`: there is no interlock, and nothing opens it."""
        self._hold_s = hold_s
        self._opens_s = math.inf if closed else -math.inf
        self.closed = closed

    def edge(self, when: float) -> None:
        """Close the relay, or hold it: an edge has come."""
        self.closed = True
        self._opens_s = max(self._opens_s, when + self._hold_s)

    def hold(self, *, on: bool) -> None:
        """Follow a line's level, where there is no one-shot before the relay."""
        self.closed, self._opens_s = on, math.inf if on else -math.inf

    def drop(self, until_s: float) -> float | None:
        """Return when it opened, once, if it has by this time."""
        if not self.closed or until_s <= self._opens_s:
            return None
        self.closed = False
        return self._opens_s
