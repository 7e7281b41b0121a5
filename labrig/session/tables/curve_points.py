"""The points of one curve while they are read, and the curve they make."""

from __future__ import annotations

import numpy as np

from drivers.interfaces import FloatArray
from labrig.session.tables.csv_rows import CsvRow, integer
from labrig.session.tables.decimals import from_milli, from_plain
from model.measurements import Curve

_NUMBER = "a number"


def _number_of(row: CsvRow) -> int:
    return row.get("point", integer, "a whole number from 0")


class CurvePoints:
    """Points by their number along the sheet, from the clamp."""

    def __init__(self) -> None:
        self._points: dict[int, tuple[float, ...]] = {}
        self._last: CsvRow | None = None

    def holds(self, row: CsvRow) -> bool:
        """Whether the point of a row is there already. Raises BadInputError."""
        return _number_of(row) in self._points

    def add(self, row: CsvRow) -> None:
        """Take the point of a row. Raises BadInputError."""
        number = _number_of(row)
        if number in self._points:
            raise row.fault(f"column point: point {number} of this curve is there twice")
        nothing = float("nan")
        self._points[number] = (
            row.get("x_mm", from_milli, _NUMBER),
            row.get("y_mm", from_milli, _NUMBER),
            row.optional("s_mm", from_milli, _NUMBER, nothing),
            row.optional("sigma_mm", from_milli, _NUMBER, nothing),
            row.optional("curvature_per_m", from_plain, _NUMBER, nothing),
            row.optional("curvature_sigma_per_m", from_plain, _NUMBER, nothing),
        )
        if self._points[number][3] < 0 or self._points[number][5] < 0:
            raise row.fault("a sigma must not be negative")
        self._last = row

    def curve(self) -> Curve:
        """Return the curve, with its arc length where no column gives it. Raises BadInputError."""
        if self._last is None:
            raise ValueError("a curve without points")
        ordered = np.array([self._points[number] for number in sorted(self._points)])
        x, y, s, sigma, curvature, curvature_sigma = ordered.T.copy()
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
        s = arc_length(x, y) if whole["s_mm"] is None else s
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


def arc_length(x_m: FloatArray, y_m: FloatArray) -> FloatArray:
    """Length along a curve through points, from the first one on.

    Each chord is lengthened to the arc of the circle that turns as the chords beside it do, so the
    error falls with the fourth power of the spacing; chords alone are off with the second.
    """
    dx, dy = np.diff(x_m), np.diff(y_m)
    chord = np.hypot(dx, dy)
    turn = np.diff(np.unwrap(np.arctan2(dy, dx)))  # at each inner point
    if turn.size == 0:
        return np.concatenate([[0.0], np.cumsum(chord)])
    # A chord turns by half of the turns at its two ends; the outermost ones as their neighbours.
    own = 0.5 * (np.concatenate([turn[:1], turn]) + np.concatenate([turn, turn[-1:]]))
    half = 0.5 * own
    longer = np.where(np.abs(half) < 1e-6, 1.0, half / np.sin(np.where(half == 0, 1.0, half)))
    return np.concatenate([[0.0], np.cumsum(chord * longer)])
