"""What a batch of images uses where an image has no files of its own beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from labrig.vision.calibration.optics import ColourChannel, SheetAppearance, StripPlace
from labrig.vision.curve import FindCurve
from labrig.vision.extraction.extract import neutral_curve


@dataclass(frozen=True, kw_only=True)
class BatchOptions:
    """What `extract_curves` uses where an image has no files of its own beside it."""

    optics: Path | None = None
    sheet: Path | None = None
    configuration: str | None = None  # which table of the sheet.toml
    overlays: bool = True
    look: SheetAppearance | None = None  # in place of that in optics.json
    find: FindCurve = neutral_curve
    is_built_in: bool = False  # whether `find` is labrig's own; `neutral_curve` is
    strips: Mapping[str, StripPlace] | None = None  # in place of those in optics.json
    facts: Mapping[str, Any] = field(default_factory=dict)  # by name, beside those in optics.json
    channel: ColourChannel | None = None  # of colour images, in place of that in optics.json
    every: int = 1  # of a video's frames and a TIFF's pages the first of each so many
