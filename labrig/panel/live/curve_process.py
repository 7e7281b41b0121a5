"""Find the curve in images, in a process of its own, which `curve_start` begins.

Setups, models and pictures come in, curves go out; it ends with its input. It may be late and it
may die: nothing waits for it.
"""

from __future__ import annotations

import sys
from contextlib import suppress

from drivers.interfaces import GreyImage
from labrig.panel.live.event_stream import Message
from labrig.panel.live.frames import image_of
from labrig.panel.live.optics_message import optics_of, strips_of
from labrig.panel.live.packing import BrokenConnectionError, pack, read, write
from labrig.panel.live.prediction import (
    Conditions,
    Predictions,
    prediction_message,
    rounded_px,
    thinned,
)
from labrig.vision import NeutralCurve, Optics, StripGeometry, Tracker


class Finder:
    """Follows the sheet through one camera's images."""

    def __init__(self) -> None:
        self._optics: Optics | None = None
        self._strips: dict[str, StripGeometry] = {}
        self._trackers: dict[str, Tracker] = {}
        self._predictions = Predictions(None)

    def setup(self, message: Message) -> None:
        """Another rig, or another sheet."""
        self._optics, self._strips = optics_of(message), strips_of(message)
        self._trackers = {}

    def choose_model(self, path: str | None) -> None:
        """Whose predictions are drawn."""
        self._predictions = Predictions(path)

    def curve(self, header: Message, image: GreyImage) -> Message:
        """Return what is seen, and what was to be expected."""
        name = header["configuration"] or next(iter(self._strips), "")
        found = self._seen(name, image)
        tip = None if not found.ok else [1e3 * float(found.x_m[-1]), 1e3 * float(found.y_m[-1])]
        return {
            "type": "curve",
            "frame": header["frame"],
            "time_s": header.get("time_s"),
            "run": header["run"],
            "ok": found.ok,
            "why": found.why,
            "points_px": rounded_px(thinned(found.points_px)),
            "covered": round(float(found.covered), 3),
            "tip_mm": tip,
            "model": self._expected(name, header, found),
        }

    def _seen(self, name: str, image: GreyImage) -> NeutralCurve:
        if self._optics is None or name not in self._strips:
            return NeutralCurve(ok=False, why="camera or sheet are not known.")
        if name not in self._trackers:
            self._trackers[name] = Tracker(self._optics, self._strips[name])
        return self._trackers[name].curve(image)

    def _expected(self, name: str, header: Message, found: NeutralCurve) -> Message | None:
        position_mm, voltage_V = header["position_mm"], header["voltage_V"]
        if self._optics is None or voltage_V is None:
            return None
        predicted = self._predictions.at(
            Conditions(configuration=name, position_mm=position_mm, voltage_V=voltage_V)
        )
        if predicted is None:
            return None
        return prediction_message(
            predicted,
            found,
            self._optics,
            voltage_V=voltage_V,
            measured_mN=header.get("force_mN"),
        )


def main() -> None:
    """Serve until the input ends."""
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
