"""Rows of numbers on a time grid, of which the last ones are kept."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


class RowBuffer:
    """Rows of numbers, one a step of the grid; the oldest are forgotten after `keep` rows."""

    def __init__(self, first: npt.NDArray[np.floating], keep: int) -> None:
        self._rows = np.empty((4096, first.size), first.dtype)
        self._rows[0] = first
        self._used = 1
        self._base = 0  # step of row 0
        self._keep = keep

    @property
    def last(self) -> int:
        """The newest step."""
        return self._base + self._used - 1

    @property
    def oldest(self) -> int:
        """The oldest step that is still known."""
        return self._base

    def append(self, rows: FloatArray) -> None:
        """Add rows (n, columns)."""
        if self._used + len(rows) > len(self._rows):
            self._make_room(len(rows))
        self._rows[self._used : self._used + len(rows)] = rows
        self._used += len(rows)

    def replace(self, row: FloatArray, count: int = 1) -> None:
        """Let this be the newest row, or so many of the newest."""
        self._rows[max(0, self._used - count) : self._used] = row

    def at(self, steps: npt.NDArray[np.int64]) -> FloatArray:
        """Rows of steps; a forgotten one is answered with the oldest known."""
        return self._rows[np.minimum(np.maximum(steps - self._base, 0), self._used - 1)]

    def _make_room(self, wanted: int) -> None:
        drop = self._used - self._keep if self._used >= 2 * self._keep else 0
        size = max(2 * (self._used - drop), self._used - drop + wanted)
        rows = np.empty((size, self._rows.shape[1]), self._rows.dtype)
        rows[: self._used - drop] = self._rows[drop : self._used]
        self._rows, self._base, self._used = rows, self._base + drop, self._used - drop
