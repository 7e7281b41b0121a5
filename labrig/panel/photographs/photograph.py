"""One photograph as the page shows it: its state, its curves, its small picture."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from labrig.panel.live.event_stream import Message
from labrig.vision import NeutralCurve
from labrig.vision.facts.catalogue import strip_facts
from labrig.vision.image.names import PictureLabel
from labrig.vision.image.overlay import jpeg_bytes, picture_with
from labrig.vision.image.review import PictureDecision
from labrig.vision.image.tables import LabelledCurve

OWN_TOOLS = {"--along-px": "Direction"}  # of the page, besides those of facts
THUMBNAIL_PX = 320  # long side
Found = list[tuple[str, NeutralCurve]]  # by the strips' names


def for_the_page(sentence: str) -> str:
    """Return a sentence with the page's tools in place of the command's options."""
    of_facts = {f.option.flag: f.tool.label for f in strip_facts().values() if f.tool is not None}
    for flag, label in (OWN_TOOLS | of_facts).items():
        sentence = sentence.replace(flag, label)
    return sentence


@dataclass(kw_only=True)
class Photograph:
    """What is known of a photograph; changed by one thread, under the folder's lock."""

    label: PictureLabel
    path: Path
    state: str = "waiting"  # waiting, found, refused, unreadable, new (something is to be clicked)
    why: str = ""
    curves: Found = field(default_factory=list)
    size: tuple[int, int] | None = None  # columns, rows
    thumbnail: bytes = b""
    revision: int = 0
    decision: PictureDecision | None = None
    own: bool = False  # whether it has an optics.json or sheet.toml of its own

    @property
    def name(self) -> str:
        """Its name among those of the folder."""
        return self.label.name

    def rows(self) -> list[LabelledCurve]:
        """Return its curves for the tables; the reason where there is none, or a person refused."""
        if self.decision is not None and self.decision.decision == "refused":
            return [(self.label, NeutralCurve(ok=False, why=self.decision.why_refused))]
        if not self.curves:
            return [(self.label, NeutralCurve(ok=False, why=self.why))]
        return [(self.label.of_strip(strip), curve) for strip, curve in self.curves]

    def message(self) -> Message:
        """Return its line in the list."""
        decision = self.decision
        return {
            "name": self.name,
            "file": self.path.name,
            "size": None if self.size is None else list(self.size),
            "state": self.state,
            "why": for_the_page(self.why),
            "warnings": [
                for_the_page(f"{strip}: {text}" if strip else text)
                for strip, curve in self.curves
                for text in curve.warnings
            ],
            "decision": None if decision is None else decision.decision,
            "note": "" if decision is None else decision.note,
            "own": self.own,
            "revision": self.revision,
        }

    def show(self, image: np.ndarray[Any, Any], curves: Found) -> None:
        """Take what was found in its image."""
        self.size = (image.shape[1], image.shape[0])
        self.curves = curves
        refused = [(strip, curve.why) for strip, curve in curves if not curve.ok]
        self.state = "refused" if refused else "found"
        self.why = " ".join(f"{strip}: {why}" if strip else why for strip, why in refused)
        self.draw(image)

    def draw(self, image: np.ndarray[Any, Any]) -> None:
        """Make its small picture anew."""
        curves = [curve for _, curve in self.curves]
        drawn = picture_with(image, curves, THUMBNAIL_PX, line_px=2)
        self.thumbnail = jpeg_bytes(drawn)

    def curve_messages(self) -> list[Message]:
        """Return its curves as the page draws them, raw pixels."""
        return [
            {
                "strip": strip,
                "ok": curve.ok,
                "why": for_the_page(curve.why),
                "refused_at_px": curve.refused_at_px,
                "covered": curve.covered,
                "points_px": np.round(curve.points_px, 2).tolist(),
                "seen": curve.seen.tolist(),
            }
            for strip, curve in self.curves
        ]
