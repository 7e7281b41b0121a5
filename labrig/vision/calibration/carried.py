"""What a new calibration takes from the optics.json it replaces: what was stated there by hand."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from labrig.errors import BadInputError
from labrig.vision.calibration.optics import Optics, listed, load_optics

# No calibration measures these; the rest is of the calibration that is replaced.
_BY_HAND = ("polarity", "look", "channel", "bits", "clamp_sigma_px", "clamp_angle_sigma_rad")
_IN_PIXELS = ("rolls_px", "strips")  # as all facts are


@dataclass(frozen=True)
class CarriedOver:
    """A new calibration with what was stated by hand before, and a sentence about that."""

    optics: Optics
    told: str = ""  # empty: nothing was stated


def carried_over(found: Optics, path: Path) -> CarriedOver:
    """Return a calibration with what the optics.json that it replaces states besides.

    What is stated in pixels is left out where images have another size now.
    """
    if not path.is_file():
        return CarriedOver(found)
    try:
        before = load_optics(path)
    except BadInputError as error:
        return CarriedOver(found, f"nothing is taken over from the one before: {error}")
    kept = _stated(before, _BY_HAND)
    dropped: list[str] = []
    in_pixels = _stated(before, _IN_PIXELS) | before.facts
    if before.image_size in (None, found.image_size):
        kept |= in_pixels
    else:
        dropped += in_pixels
    dropped += _stated(before, ("note",))
    return CarriedOver(found.model_copy(update=kept), _told(kept, in_pixels, dropped))


def _stated(optics: Optics, names: tuple[str, ...]) -> dict[str, Any]:
    """Return the values that are not the usual ones."""
    usual = type(optics).model_fields
    found = {name: getattr(optics, name) for name in names}
    return {name: value for name, value in found.items() if value != usual[name].default}


def _told(kept: dict[str, Any], in_pixels: dict[str, Any], dropped: list[str]) -> str:
    parts = []
    if kept:
        moved = "; where the camera has moved, correct them" if in_pixels.keys() & kept else ""
        parts.append(f"taken over from the one before: {listed(list(kept))}{moved}")
    if dropped:
        parts.append(f"not taken over from the one before: {listed(dropped)}")
    return "; ".join(parts)
