"""The neutral curves that an analysis has kept in a session, to draw over their images."""

from __future__ import annotations

from bisect import bisect_left
from pathlib import Path

import numpy as np

from labrig.errors import LabrigError
from labrig.panel.live.event_stream import Message
from labrig.session import RecordedSession, load_measurements
from labrig.vision import Optics
from model.measurements import Curve

_NEAR_S = 0.1  # a reading's frame is not further from its sampling point
_DECIMALS = 2


class StoredCurves:
    """Of one session; empty where it was not analysed. Read when first asked for."""

    def __init__(self, session: RecordedSession, path: Path, optics: Optics | None) -> None:
        self._session = session
        self._path = path
        self._optics = optics
        self._found: tuple[list[float], list[Curve]] | None = None

    def message(self, frame: int, run: int, at_s: float) -> Message | None:
        """Return the curve of the reading at a time of the session, as pages draw it."""
        times_s, curves = self._all()
        at = bisect_left(times_s, at_s)
        near = [i for i in (at - 1, at) if 0 <= i < len(times_s) and self._is_near(i, at_s)]
        if not near or self._optics is None:
            return None
        curve = curves[min(near, key=lambda i: abs(times_s[i] - at_s))]
        points = self._optics.world_to_pixel(np.column_stack([curve.x_m, curve.y_m]))
        return {
            "type": "curve",
            "frame": frame,
            "run": run,
            "ok": True,
            "why": "",
            "points_px": np.round(points, _DECIMALS).tolist(),
            "covered": None,
            "tip_mm": [1e3 * float(curve.x_m[-1]), 1e3 * float(curve.y_m[-1])],
            "model": None,
            "stored": True,
        }

    def _is_near(self, index: int, at_s: float) -> bool:
        return abs(self._all()[0][index] - at_s) < _NEAR_S

    def _all(self) -> tuple[list[float], list[Curve]]:
        if self._found is None:
            pairs = sorted(self._pairs(), key=lambda pair: pair[0])
            self._found = ([time_s for time_s, _ in pairs], [curve for _, curve in pairs])
        return self._found

    def _pairs(self) -> list[tuple[float, Curve]]:
        if not self._session.has_measurements:
            return []
        try:
            found = load_measurements(self._path)
        except LabrigError:  # what cannot be read is not drawn
            return []
        return [
            (reading.session_s, reading.curve)
            for condition in found.conditions
            for reading in condition.readings
            if reading.curve is not None and reading.session_s is not None
        ]
