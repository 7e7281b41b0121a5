"""The curves of single frames of a run, at fixed points along the sheet."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drivers.interfaces import FloatArray
from labrig.extractors.choice import chosen_extractor
from labrig.session import RunRecord
from labrig.vision import NeutralCurve, Optics, StripGeometry
from model.measurements import SheetGeometry

CURVE_POINTS = 8  # of a frame's curve: about as many as it has independent ones
REACH = 0.98  # of the sheet: its very end is not seen
POOR = 3.0  # a point so many times less certain than usual, as where it is blurred, is not used


@dataclass(frozen=True, kw_only=True)
class FrameCurves:
    """Points of the curves of some frames, (m, p); NaN: not seen."""

    frame_s: FloatArray  # (m,) middle of the exposures
    points_m: FloatArray  # (p,) along the sheet
    x_m: FloatArray
    y_m: FloatArray
    failed: int  # frames without a curve
    why: str  # of the first of them


def frame_times(run: RunRecord, exposure_s: float) -> FloatArray:
    """Return the middle of each frame's exposure, s since the run's beginning.

    A frame's time stamp is its arrival. Where the camera stamps its frames itself they came at
    even, later times: the earliest arrival counts. Where it is triggered, the trigger says when.
    """
    trigger_s = run.frame_column("trigger_time")
    if len(trigger_s) and np.all(np.isfinite(trigger_s)):
        return np.asarray(trigger_s + 0.5 * exposure_s)
    time_s, device_s = run.frame_column("time"), run.frame_column("device_time")
    if len(device_s) > 1 and np.all(np.diff(device_s) > 0.0):
        time_s = device_s + float(np.min(time_s - device_s))
    return np.asarray(time_s - 0.5 * exposure_s)


def frame_curves(
    run: RunRecord,
    sheet: SheetGeometry,
    optics: Optics,
    extractor: str,
    *,
    begin_s: float,
    exposure_s: float,
    advance: Callable[[float], None],
) -> FrameCurves | None:
    """Return the curves of all frames from `begin_s` on, one followed from the last.

    None where there is no frame with a curve. advance: told how much of it is done.
    """
    times = frame_times(run, exposure_s)
    rows = np.flatnonzero(times >= begin_s)
    strip = StripGeometry(
        free_length_m=sheet.free_length_m,
        elongation_m=sheet.elongation_m,
        thickness_m=sheet.thickness_m,
    )
    find, near = chosen_extractor(extractor), None
    found: list[NeutralCurve] = []
    for done, row in enumerate(rows.tolist(), 1):
        curve = find.curve(run.image(row), optics, strip, start=near)
        near = curve if curve.ok else near
        found.append(curve)
        advance(done / len(rows))
    bad = [curve.why for curve in found if not curve.ok]
    if len(bad) == len(found):
        return None
    points_m = REACH * strip.length_m * np.arange(1, CURVE_POINTS + 1) / CURVE_POINTS
    x_m, y_m = _at(found, points_m)
    return FrameCurves(
        frame_s=times[rows] - begin_s,
        points_m=points_m,
        x_m=x_m,
        y_m=y_m,
        failed=len(bad),
        why=bad[0] if bad else "",
    )


def _at(curves: list[NeutralCurve], points_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    x, y, sigma = (np.full((len(curves), len(points_m)), np.nan) for _ in range(3))
    for row, curve in enumerate(curves):
        if not curve.ok:
            continue
        x[row], y[row] = (np.interp(points_m, curve.s_m, one) for one in (curve.x_m, curve.y_m))
        seen = np.interp(points_m, curve.s_m, curve.seen.astype(float)) if curve.seen.size else 1.0
        beyond = points_m > curve.s_m[-1] * (1.0 + 1e-6)
        sigma[row] = np.interp(points_m, curve.s_m, curve.sigma_m)
        x[row, (seen < 0.5) | beyond] = np.nan
    y[sigma > POOR * np.nanmedian(sigma, axis=0)] = np.nan
    unseen = ~np.isfinite(x + y)
    x[unseen] = y[unseen] = np.nan
    return x, y
