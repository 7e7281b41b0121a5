"""The decisions of a person about a folder's curves, kept beside them in curves_review.json."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from pydantic import Field

from labrig.config.base import ClosedModel, parse_json, read_text, validate
from labrig.files import write_text

REVIEW_FILE = "curves_review.json"


class PictureDecision(ClosedModel):
    """One picture's curve, accepted or refused by a person."""

    decision: Literal["accepted", "refused"]
    who: str = Field("", max_length=80)
    date: str = Field("", max_length=40, description="ISO 8601")
    note: str = Field("", max_length=400)
    known: str = Field("", max_length=64, description="of what the accepted curve was made")

    @property
    def why_refused(self) -> str:
        """The sentence in place of a curve."""
        who = f" by {self.who}" if self.who else ""
        note = f": {self.note.rstrip('.')}" if self.note else ""
        return f"refused by hand{who}, {self.date}{note} ({REVIEW_FILE})."


class Review(ClosedModel):
    """curves_review.json: decisions by the pictures' names."""

    pictures: dict[str, PictureDecision] = Field(default_factory=dict)


def load_review(folder: Path) -> dict[str, PictureDecision]:
    """Return what was decided about a folder's pictures, by name. Raises BadInputError."""
    path = folder / REVIEW_FILE
    if not path.exists():
        return {}
    return dict(validate(Review, parse_json(read_text(path), str(path)), str(path)).pictures)


def save_review(folder: Path, decisions: Mapping[str, PictureDecision]) -> None:
    """Write curves_review.json, whole or not at all."""
    pictures = {
        name: decision.model_dump(exclude_defaults=True)
        for name, decision in sorted(decisions.items())
    }
    write_text(folder / REVIEW_FILE, json.dumps({"pictures": pictures}, indent=1) + "\n")
