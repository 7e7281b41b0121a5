"""What every curve extractor must fulfil: `faults` finds nothing in a good one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Final

import numpy as np

from labrig.extractors.examples import STRIP, Example, examples
from labrig.vision import NeutralCurve

COLUMNS: Final = (
    "s_m", "x_m", "y_m", "sigma_m", "curvature_per_m", "curvature_sigma_per_m"
)  # fmt: skip
OFF_LIMIT_PX: Final = 0.5  # RMS of an example's curve from the truth; its noise is 1/40 of contrast
SIGMA_RANGE_M: Final = (1e-8, 1e-3)  # of the examples; what is outside is in another unit
LENGTH_LIMIT: Final = 0.03  # relative, of an example's length from the truth
ARC_LIMIT: Final = 0.01  # relative, of `s_m` from the length along the points
PLACE_LIMIT_PX: Final = 0.1  # of `points_px` from where the optics show the points
CURVATURE_LIMIT_PER_M: Final = 8.0  # median over an example's curve from the truth


def faults(extractor: object) -> list[str]:
    """Return what is wrong with an extractor, a sentence each without its full stop."""
    found = list(_faults_of_form(extractor))
    if found:
        return found
    part: Any = extractor
    for example in examples():
        wrong = [f"{example.name}: {text}" for text in _faults_on(part.curve, example)]
        if wrong:
            return wrong  # the images are alike, so the first one's faults say it all
    return []


def _faults_of_form(extractor: object) -> Iterator[str]:
    summary = getattr(extractor, "summary", None)
    if not isinstance(summary, str) or not summary.strip().endswith("."):
        yield "summary must be one sentence with its full stop"
    if not callable(getattr(extractor, "curve", None)):
        yield "it has no method curve(image, optics, strip, *, start=None)"


def _faults_on(curve: Callable[..., object], example: Example) -> list[str]:
    """Return what is wrong with its answers to one image."""
    image = example.image.copy()
    try:
        found = curve(image, example.optics, STRIP)
        wrong = list(_faults_of_answer(found, example))
        if not np.array_equal(image, example.image):
            wrong.append("it changes the image")
        if wrong or not isinstance(found, NeutralCurve):
            return wrong
        if not _same(found, curve(image, example.optics, STRIP)):
            return ["it gives another answer to the same image"]
        if not found.ok:
            return []
        followed = curve(image, example.optics, STRIP, start=found)
        return [f"with `start`: {text}" for text in _faults_of_answer(followed, example)]
    except (Exception, SystemExit) as error:  # noqa: BLE001 - other people's code may raise anything
        return [f"it raised {type(error).__name__}: {error}"]


def _same(one: NeutralCurve, other: object) -> bool:
    return isinstance(other, NeutralCurve) and all(
        np.array_equal(getattr(one, name), getattr(other, name))
        for name in ("ok", "why", *COLUMNS, "points_px")
    )


def _faults_of_answer(found: object, example: Example) -> Iterator[str]:
    if not isinstance(found, NeutralCurve):
        yield f"it returned {type(found).__name__}, not a NeutralCurve"
        return
    wrong = faults_of_curve(found)
    yield from wrong
    if wrong or not found.ok:
        if example.curvature_per_m is not None and not found.ok:
            yield f"it finds no curve: {found.why}"
    elif example.curvature_per_m is None:
        yield "it finds a curve where no strip is"
    else:
        yield from _faults_of_place(found, example, example.curvature_per_m)


def faults_of_curve(curve: NeutralCurve) -> list[str]:
    """Return what is wrong with the form of an answer: a missing reason, shapes, units."""
    if not curve.ok:
        reason = curve.why.strip()
        return [] if reason.endswith(".") else ["a refusal needs a sentence in `why`"]
    points = len(curve.s_m)
    if points < 2:
        return ["a curve needs at least two points"]
    shapes = {name: np.shape(getattr(curve, name)) for name in (*COLUMNS, "points_px", "seen")}
    wanted = dict.fromkeys(shapes, (points,)) | {"points_px": (points, 2)}
    wrong = [
        f"{name} has the shape {shapes[name]}, not {wanted[name]}"
        for name in shapes
        if shapes[name] != wanted[name]
    ]
    return wrong or list(_faults_of_values(curve))


def _faults_of_values(curve: NeutralCurve) -> Iterator[str]:
    for name in (*COLUMNS, "points_px"):
        if not np.isfinite(getattr(curve, name)).all():
            yield f"{name} holds values that are not finite"
    if not (curve.sigma_m > 0).all():
        yield "sigma_m must be above 0"
    if curve.s_m[0] != 0 or not (np.diff(curve.s_m) > 0).all():
        yield "s_m must begin at 0 and increase"
    if not 0 <= curve.covered <= 1:
        yield "covered must be a share, from 0 to 1"
    if not curve.thickness_m > 0:
        yield "thickness_m must be above 0"


def _faults_of_place(
    found: NeutralCurve, example: Example, curvature_per_m: float
) -> Iterator[str]:
    """Yield how a curve differs from the strip that was drawn."""
    optics = example.optics
    length_m = float(found.s_m[-1])
    if abs(length_m / STRIP.length_m - 1) > LENGTH_LIMIT:
        yield f"s_m ends at {length_m:g} m, the strip at {STRIP.length_m:g}"
    low_m, high_m = SIGMA_RANGE_M
    if not ((found.sigma_m > low_m) & (found.sigma_m < high_m)).all():
        yield f"sigma_m is {np.median(found.sigma_m):g} (median); it is a length in m"
    arc_m = float(np.hypot(np.diff(found.x_m), np.diff(found.y_m)).sum())
    if abs(arc_m / length_m - 1) > ARC_LIMIT:
        yield f"s_m ends at {length_m:g} m, but the points are {arc_m:g} m long"
    off_px = np.sqrt(np.mean(example.distances_m(found.x_m, found.y_m) ** 2)) * optics.px_per_m
    if off_px > OFF_LIMIT_PX:
        yield f"the curve is {off_px:.2f} pixels (RMS) from the strip"
    shown = optics.world_to_pixel(np.column_stack([found.x_m, found.y_m]))
    apart_px = float(np.abs(shown - found.points_px).max())
    if apart_px > PLACE_LIMIT_PX:
        yield f"points_px are up to {apart_px:.2f} pixels from where the optics show the points"
    bent = float(np.median(found.curvature_per_m)) - curvature_per_m
    if abs(bent) > CURVATURE_LIMIT_PER_M:
        yield f"curvature_per_m is {bent:+.1f} per m from the strip's (median)"
