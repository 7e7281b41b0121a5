"""The points of one curve while they are read, and the curve they make."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from drivers.interfaces import FloatArray
from labrig.session.tables.csv_rows import CsvRow, TextTable, integer
from labrig.session.tables.decimals import from_milli, from_plain
from model.measurements import Curve
from model.measurements.arc_length import arc_length_m

IntArray = npt.NDArray[np.int64]
# our columns: in thousandths, needed
_COLUMNS = {
    "x_mm": (True, True),
    "y_mm": (True, True),
    "s_mm": (True, False),
    "sigma_mm": (True, False),
    "curvature_per_m": (False, False),
    "curvature_sigma_per_m": (False, False),
}
_SIGMAS = [3, 5]  # of these


def numbers_of(table: TextTable, of_a_curve: Sequence[str]) -> IntArray:
    """Return the points' numbers; without such a column the lines of each curve are counted."""
    count = len(table.lines)
    if not table.has("point"):
        done: Counter[tuple[str, ...]] = Counter()
        found = np.zeros(count, dtype=np.int64)
        for first, end in table.blocks(of_a_curve):
            key = tuple(table.text(first, name) for name in of_a_curve)
            found[first:end] = np.arange(done[key], done[key] + end - first)
            done[key] += end - first
        return found
    return np.array(
        [row.get("point", integer, "a whole number from 0") for row in table.rows()],
        dtype=np.int64,
    )


class CurvePoints:
    """Points by their number along the sheet, from the clamp."""

    def __init__(self) -> None:
        self._numbers: set[int] = set()
        self._parts: list[tuple[IntArray, FloatArray]] = []
        self._last: CsvRow | None = None

    @staticmethod
    def columns_of(table: TextTable) -> FloatArray:
        """Return what is read of each point, (6, lines); NaN where it is not stated."""
        found = np.array(
            [
                table.numbers(name, from_milli if mm else from_plain, milli=mm, needed=needed)
                for name, (mm, needed) in _COLUMNS.items()
            ]
        )
        negative = np.flatnonzero((found[_SIGMAS] < 0).any(axis=0))
        if negative.size:
            raise table.row(int(negative[0])).fault("a sigma must not be negative")
        return found

    def holds(self, numbers: IntArray) -> bool:
        """Whether one of these points is there already."""
        return not self._numbers.isdisjoint(numbers.tolist())

    def add(self, table: TextTable, first: int, numbers: IntArray, points: FloatArray) -> None:
        """Take the points of lines from `first` on. Raises BadInputError where one is there."""
        for at, number in enumerate(numbers.tolist()):
            if number in self._numbers:
                raise table.row(first + at).fault(
                    f"column point: point {number} of this curve is there twice; where the position"
                    " was set anew, column mounting tells its set-ups apart (0, 1, 2, ...)"
                )
            self._numbers.add(number)
        end = first + len(numbers)
        self._parts.append((numbers, points[:, first:end]))
        self._last = table.row(end - 1)

    def curve(self) -> Curve:
        """Return the curve, with its arc length where no column gives it. Raises BadInputError."""
        if self._last is None:
            raise ValueError("a curve without points")
        order = np.argsort(np.concatenate([numbers for numbers, _ in self._parts]))
        ordered = np.concatenate([points for _, points in self._parts], axis=1)[:, order]
        x, y, s, sigma, curvature, curvature_sigma = ordered
        if len(x) < 3:
            raise self._last.fault("its curve has fewer than three points")
        whole = {
            name: self._whole(name, values)
            for name, values in (
                ("s_mm", s),
                ("sigma_mm", sigma),
                ("curvature_per_m", curvature),
                ("curvature_sigma_per_m", curvature_sigma),
            )
        }
        s = arc_length_m(x, y) if whole["s_mm"] is None else s
        if np.any(np.diff(s) <= 0):
            raise self._last.fault("two neighbouring points of its curve are the same place")
        return Curve(
            s_m=s,
            x_m=x,
            y_m=y,
            curvature_per_m=whole["curvature_per_m"],
            sigma_m=whole["sigma_mm"],
            curvature_sigma_per_m=whole["curvature_sigma_per_m"],
        )

    def _whole(self, name: str, values: FloatArray) -> FloatArray | None:
        """Return a column that is there for all points; None when it is there for none."""
        missing = np.isnan(values)
        if missing.any() and not missing.all() and self._last is not None:
            raise self._last.fault(f"column {name} is empty for some points of its curve")
        return None if missing.any() else values
