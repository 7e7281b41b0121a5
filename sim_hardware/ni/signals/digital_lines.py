"""Levels of the boards' digital lines, and when they changed."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class LineEdge:
    """A change of a line's level."""

    time_s: float
    line: str  # PCI6703/port0/line0
    high: bool


class Lines:
    """Static digital lines: each keeps its level until it is written again."""

    KEPT_EDGES = 100_000

    def __init__(self) -> None:
        self._high: dict[str, bool] = {}
        self.edges: deque[LineEdge] = deque(maxlen=self.KEPT_EDGES)
        # called for each edge with the line, its new level and the time
        self.wired: Callable[[str, bool, float], None] | None = None

    def level(self, line: str) -> bool:
        """Return whether a line is high; it is low until written."""
        return self._high.get(line, False)

    def write(self, line: str, high: bool, when: float) -> None:
        """Set a line."""
        if high != self.level(line):
            self.edges.append(LineEdge(when, line, high))
            if self.wired is not None:
                self.wired(line, high, when)
        self._high[line] = high

    def last_edge_s(self, line: str) -> float | None:
        """Return when a line last changed, as a one-shot behind it sees; None if never."""
        return next((edge.time_s for edge in reversed(self.edges) if edge.line == line), None)
