"""What is clicked on a photograph, as optics.json and sheet.toml beside it."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from labrig.errors import BadInputError
from labrig.files import keep_replaced, write_text
from labrig.vision import Optics, calibrate_ruler, load_optics
from labrig.vision.calibration.optics import StripPlace
from labrig.vision.facts.catalogue import strip_facts
from labrig.vision.facts.contract import FactOf, StripFact
from labrig.vision.facts.stated import places_of
from labrig.vision.facts.values import Point
from labrig.vision.image.beside import OPTICS_FILE, SHEET_FILE, beside, own_file

CLICK_SIGMA_PX = 2.0  # of a place that was clicked
UNMOVED_PX = 0.05  # nearer to the known place than that it was not clicked anew
ALONG_M = 0.005  # from the clamp to the place that shows its direction
METHOD = "clicked on the page"
_SAMPLES, _SAMPLE_BYTES = 64, 16384  # up to 1 MB of a file


@dataclass(frozen=True, kw_only=True)
class Clicked:
    """What was clicked and typed; None: as it was."""

    strips: dict[str, StripPlace]  # one without a name where there is one only, with its facts
    ruler_px: tuple[Point, Point] | None = None
    ruler_mm: float | None = None
    facts: dict[str, Any] = field(default_factory=dict)  # of the pictures, such as a mask
    lengths_mm: dict[str, float] | None = None  # free_length_mm, elongation_mm, thickness_mm


def changed_optics(base: Optics | None, size: tuple[int, int], clicked: Clicked) -> Optics:
    """Return the optics of a picture (columns, rows) with what was clicked.

    Raises BadInputError where something is missing.
    """
    first = next(iter(clicked.strips.values()), None)
    if first is None:
        raise BadInputError("the clamp is missing: click where the strip leaves it.")
    for place in clicked.strips.values():
        _check_inside(place, size)
    optics = _scaled(base, size, clicked, first)
    changed: dict[str, object] = {"image_size": size}
    changed |= {fact.name: clicked.facts.get(fact.name) for fact in clicked_facts(FactOf.PICTURE)}
    if base is not None and _as_before(base, clicked.strips):
        return _with_places(optics, clicked.strips).model_copy(update=changed)
    sigma = CLICK_SIGMA_PX / _apart_px(first) if first.along_px else optics.clamp_angle_sigma_rad
    changed |= {
        "clamp_sigma_px": max(CLICK_SIGMA_PX, optics.clamp_sigma_px),
        "clamp_angle_sigma_rad": max(optics.clamp_angle_sigma_rad, math.sqrt(2) * sigma),
        "strips": clicked.strips if "" not in clicked.strips else None,
    }
    there = optics.at(first)
    if "" not in clicked.strips:  # each has its own facts
        there = there.model_copy(update={"facts": there.facts_that_are(FactOf.PICTURE)})
    return there.model_copy(update=changed)


def _with_places(optics: Optics, strips: dict[str, StripPlace]) -> Optics:
    """Return optics with the places that were clicked on each strip, and its clamp as it was."""
    if not optics.strips:
        kept = optics.facts_that_are(FactOf.PICTURE)
        return optics.model_copy(update={"facts": kept | strips[""].facts})
    changed = {
        name: old.model_copy(update={"facts": strips[name].facts})
        for name, old in optics.strips.items()
    }
    return optics.model_copy(update={"strips": changed})


def clicked_facts(of: FactOf) -> list[StripFact]:
    """Return the facts that have a tool on the page."""
    return [fact for fact in strip_facts().values() if fact.tool is not None and fact.of == of]


def _as_before(base: Optics, strips: dict[str, StripPlace]) -> bool:
    """Return whether clamps and directions are those that were known, perhaps from a board."""
    before = base.by_strip()
    return before.keys() == strips.keys() and all(
        math.dist(place.clamp_px, before[name].clamp_px) < UNMOVED_PX
        and _leads_as_before(place, before[name])
        for name, place in strips.items()
    )


def _leads_as_before(place: StripPlace, before: Optics) -> bool:
    if place.along_px is None:
        return True
    known = along_px(before)
    return known is not None and math.dist(place.along_px, known) < UNMOVED_PX


def along_px(optics: Optics) -> Point | None:
    """Return a pixel further along the clamped strip; None where its direction is not known."""
    if not optics.clamp_angle_known:
        return None
    x, y = optics.clamp_m()
    angle = optics.clamp_angle_rad
    ahead = (x + ALONG_M * math.cos(angle), y + ALONG_M * math.sin(angle))
    u, v = optics.world_to_pixel([ahead])[0]
    return float(u), float(v)


def _scaled(
    base: Optics | None, size: tuple[int, int], clicked: Clicked, first: StripPlace
) -> Optics:
    """Return the optics with a new scale where a ruler was clicked, else as they were."""
    if clicked.ruler_px is None:
        if base is None:
            raise BadInputError(
                "the scale is missing: click both ends of a ruler and state its length."
            )
        return base
    if clicked.ruler_mm is None:
        raise BadInputError("the ruler's length is missing: state it in mm.")
    made = calibrate_ruler(size, *clicked.ruler_px, clicked.ruler_mm, clamp_px=first.clamp_px)
    scale = {
        "px_per_mm": made.optics.px_per_mm,
        "px_per_mm_sigma": made.optics.px_per_mm_sigma,
        "method": METHOD,
        "date": made.optics.date,
    }
    if base is None or base.homography is not None:
        return made.optics.model_copy(update=scale)
    return base.model_copy(update=scale)


def _check_inside(place: StripPlace, size: tuple[int, int]) -> None:
    places = [("clamp", place.clamp_px), ("direction", place.along_px)]
    for fact in clicked_facts(FactOf.STRIP):
        if fact.tool is not None and fact.name in place.facts:
            found = places_of(fact, place.facts[fact.name])
            places += [(fact.tool.noun, point) for point in found]
    for name, point in places:
        if point is not None and not (0 <= point[0] < size[0] and 0 <= point[1] < size[1]):
            raise BadInputError(f"the {name} lies outside of the picture; click it again.")


def _apart_px(place: StripPlace) -> float:
    return math.dist(place.clamp_px, place.along_px or place.clamp_px)


def known_optics(path: Path, *, common: bool = False) -> Optics | None:
    """Return the optics that a picture uses, or with `common` those of the folder; None: none."""
    file = path.with_name(OPTICS_FILE) if common else beside(path, OPTICS_FILE, None)
    return load_optics(file) if file is not None and file.exists() else None


def write_known(path: Path, optics: Optics, clicked: Clicked, *, for_all: bool) -> list[str]:
    """Write what is known beside a picture, for it or for all; return the files' names.

    Places on its strip are for it alone. A file of the user's is kept under another name.
    """
    optics = optics.model_copy(update={"note": METHOD})
    common = optics.without_places() if for_all else optics
    texts = {OPTICS_FILE: common.to_json()}
    if clicked.lengths_mm:
        lines = [f"{key} = {value:g}" for key, value in clicked.lengths_mm.items()]
        texts[SHEET_FILE] = "\n".join([f"# {METHOD}", *lines]) + "\n"
    written = []
    for kind, text in texts.items():
        own = own_file(path, kind)
        places = [path.with_name(kind)] if for_all else [own]
        if for_all and own.exists():
            places.append(own)  # its own file stands above that of all
        for place in places:
            _keep_users_own(place, text)
            write_text(place, text)
            written.append(place.name)
    if common != optics:
        own = own_file(path, OPTICS_FILE)
        write_text(own, optics.to_json())
        written += [own.name] if own.name not in written else []
    return written


def _keep_users_own(path: Path, text: str) -> None:
    """Keep a file that the page did not write, and that `text` is to replace, as NAME.DATE.bak."""
    if path.exists() and METHOD not in path.read_text(encoding="utf-8", errors="replace"):
        keep_replaced(path, text)


def digest_of(path: Path) -> str:
    """Return what stands for a picture and all that is known of it; it changes when one does."""
    found = hashlib.sha256(_sample(path))
    for kind in (OPTICS_FILE, SHEET_FILE):
        file = beside(path, kind, None)
        found.update(b"\0" if file is None or not file.exists() else file.read_bytes())
    return found.hexdigest()[:32]


def _sample(path: Path) -> bytes:
    """Return the size and parts of a file: stacks of pages may be too large to read whole."""
    try:
        size = path.stat().st_size
        with path.open("rb") as file:
            parts = [b"%d" % size]
            for start in range(0, size, max(_SAMPLE_BYTES, size // _SAMPLES)):
                file.seek(start)
                parts.append(file.read(_SAMPLE_BYTES))
    except OSError:
        return b""
    return b"".join(parts)
