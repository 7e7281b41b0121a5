"""Find the curve in images, in a process: `python -m labrig.panel.live.curve_process`.

Setups, models and pictures come in, curves go out; it ends with its input. It may be late and it
may die: nothing waits for it.
"""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from drivers.interfaces import GreyImage
from labrig.errors import LabrigError
from labrig.model_file import load_model
from labrig.panel.live.event_stream import Message
from labrig.panel.live.frames import image_of
from labrig.panel.live.optics_message import optics_of, strips_of
from labrig.panel.live.packing import BrokenConnectionError, pack, read, write
from labrig.vision import NeutralCurve, Optics, StripGeometry, Tracker
from model import ModelError, SheetModel, predict, predict_free

MOST_POINTS = 150
_DECIMALS = 2


class Finder:
    """Follows the sheet through one camera's pictures."""

    def __init__(self) -> None:
        self._optics: Optics | None = None
        self._strips: dict[str, StripGeometry] = {}
        self._trackers: dict[str, Tracker] = {}
        self._model: SheetModel | None = None
        self._why_no_model = ""
        self._predicted: dict[tuple[Any, ...], Message] = {}

    def setup(self, message: Message) -> None:
        """Another rig, or another sheet."""
        self._optics, self._strips = optics_of(message), strips_of(message)
        self._trackers = {}
        self._predicted = {}

    def choose_model(self, path: str | None) -> None:
        """Whose predictions are drawn."""
        self._model, self._why_no_model, self._predicted = None, "", {}
        if path is None:
            return
        try:
            self._model = load_model(Path(path))
        except LabrigError as error:
            self._why_no_model = str(error)

    def curve(self, header: Message, image: GreyImage) -> Message:
        """Return what is seen, and what was to be expected."""
        name = header["configuration"] or next(iter(self._strips), "")
        found = self._seen(name, image)
        points = found.points_px[:: max(1, len(found.points_px) // MOST_POINTS)]
        tip = None if not found.ok else [1e3 * float(found.x_m[-1]), 1e3 * float(found.y_m[-1])]
        return {
            "type": "curve",
            "frame": header["frame"],
            "run": header["run"],
            "ok": found.ok,
            "why": found.why,
            "points_px": np.round(points, _DECIMALS).tolist(),
            "covered": round(float(found.covered), 3),
            "tip_mm": tip,
            "model": self._expected(name, header["position_mm"], header["voltage_V"]),
        }

    def _seen(self, name: str, image: GreyImage) -> NeutralCurve:
        if self._optics is None or name not in self._strips:
            return NeutralCurve(ok=False, why="camera or sheet are not known.")
        if name not in self._trackers:
            self._trackers[name] = Tracker(self._optics, self._strips[name])
        return self._trackers[name].curve(image)

    def _expected(
        self, name: str, position_mm: float | None, voltage_V: float | None
    ) -> Message | None:
        if self._why_no_model:
            return {
                "points_px": [], "voltage_V": voltage_V, "force_mN": None,
                "why": self._why_no_model,
            }  # fmt: skip
        if self._model is None or self._optics is None or voltage_V is None:
            return None
        key = (name, position_mm, voltage_V)
        if key not in self._predicted:
            self._predicted[key] = self._predict(self._model, self._optics, *key)
        return self._predicted[key]

    def _predict(
        self,
        model: SheetModel,
        optics: Optics,
        name: str,
        position_mm: float | None,
        voltage_V: float,
    ) -> Message:
        force_mN, why = None, ""
        try:
            if position_mm is None:
                _, x_m, y_m = predict_free(model, name, voltage_V)
            else:
                found = predict(model, name, position_mm / 1000, voltage_V)
                x_m, y_m, why = found.x_m, found.y_m, found.why
                force_mN = 1e3 * found.F_N if found.reachable else None
        except ModelError as error:
            x_m = y_m = np.empty(0)
            why = f"{error}."
        points = optics.world_to_pixel(np.column_stack([x_m, y_m]))
        points = points[:: max(1, len(points) // MOST_POINTS)]
        return {
            "points_px": np.round(points, _DECIMALS).tolist(),
            "voltage_V": voltage_V,
            "force_mN": force_mN,
            "why": why,
        }


def main() -> None:
    """Serve until the input ends."""
    with suppress(AttributeError, OSError):  # Windows has no nice
        os.nice(10)
    finder = Finder()
    source, sink = sys.stdin.buffer, sys.stdout.buffer
    with suppress(BrokenConnectionError, OSError, KeyboardInterrupt):
        while True:
            header, payload = read(source)
            if header["type"] == "setup":
                finder.setup(header)
            elif header["type"] == "model":
                finder.choose_model(header["path"])
            else:
                write(sink, pack(finder.curve(header, image_of(header, payload))))


if __name__ == "__main__":
    main()
