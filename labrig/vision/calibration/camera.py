"""Camera calibration: from images of a board in the sheet's plane to an optics.json.

The first image shows the board flat in the plane in which the sheet moves; it fixes the plane's
homography and, with it, scale and axes. Alone it also fixes the lens (k1, k2); further, tilted
images fix the lens better. Without a board, two points of a ruler give a scale and nothing else.
"""

from __future__ import annotations

import datetime as dt
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.errors import BadInputError
from labrig.vision.calibration.board import CalibrationBoard
from labrig.vision.calibration.corners import find_corners
from labrig.vision.calibration.lens import distort, undistort
from labrig.vision.calibration.optics import Optics, outside, project
from labrig.vision.facts.values import Point
from labrig.vision.thresholds import (
    CALIBRATION_RESIDUAL_MAX_PX,
    CALIBRATION_RESIDUAL_WARNED_PX,
    CLAMP_DIRECTION_MIN_PX,
    RULER_SHORT_MM,
    SCALE_MAX_PX_PER_MM,
)

FloatArray = npt.NDArray[np.float64]

CORNER_SIGMA_PX = 0.05


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """An optics.json to be, and what the operator should know of it."""

    optics: Optics
    residual_px: float
    residual_um: float
    largest_um: float
    warnings: tuple[str, ...] = ()


ALONG_ROWS = (
    "the sheet is taken to leave the clamp along the image's rows, to the right; a second pixel on "
    "the clamped sheet states another direction (--along-px U,V)"
)


@dataclass(frozen=True)
class _PlaneFit:
    lens: FloatArray  # k1, k2, p1, p2, k3
    homography: FloatArray  # board mm -> undistorted pixels
    residuals: FloatArray  # (n, 2) pixels
    scale_share: float  # relative standard uncertainty of the scale


def calibrate_camera(
    images: Sequence[npt.NDArray[Any]],
    board: CalibrationBoard,
    *,
    clamp_px: Point,
    along_px: Point | None = None,
    focal_px: float | None = None,
    board_scale_sigma: float = 5e-4,
    date: dt.date | None = None,
) -> Calibration:
    """Calibrate from images of `board`, the first one flat in the sheet's plane.

    `clamp_px`: the raw pixel where the sheet leaves the clamp; `along_px`: a second pixel on the
    clamped sheet's line, ahead of it (default: the image's rows). `focal_px`: a guess of the
    focal length for a single image. `board_scale_sigma`: how well the printed squares are known.
    """
    size = _common_size(images)
    _check_clamp(clamp_px, along_px, size)
    found = [find_corners(image, board, f"image {i + 1}") for i, image in enumerate(images)]
    focal = focal_px or 1.2 * max(size)
    camera = np.array([[focal, 0, (size[0] - 1) / 2], [0, focal, (size[1] - 1) / 2], [0, 0, 1.0]])
    lens, lens_sigma = np.zeros(5), np.array([0.3, 0.3])
    if len(found) >= 3:
        (camera, lens), lens_sigma = _lens_from_views(found, camera, size), np.array([0.03, 0.3])
    fit = _fit_plane(*found[0], camera, lens, lens_sigma)
    return _as_calibration(
        fit,
        camera,
        size,
        clamp_px,
        along_px=along_px,
        board_scale_sigma=board_scale_sigma,
        date=date,
        views=len(images),
    )


def calibrate_ruler(
    image_size: tuple[int, int],
    first_px: Point,
    second_px: Point,
    distance_mm: float,
    *,
    clamp_px: Point,
    along_px: Point | None = None,
    reading_sigma_px: float = 0.7,
    date: dt.date | None = None,
) -> Calibration:
    """Return the scale from two points of a ruler in the sheet's plane.

    Each is read to `reading_sigma_px`. The ruler may lie in any direction: the x axis runs from
    `clamp_px` to `along_px`, a second pixel on the clamped sheet (default: along the image's rows,
    and the sheet's direction is found in each image). Raises BadInputError where a place lies
    outside of the image, or the ruler's points are too close.
    """
    _check_clamp(clamp_px, along_px, image_size)
    for place in (first_px, second_px):
        _inside(place, "the ruler's point", image_size)
    length = math.dist(first_px, second_px)
    if not 0 < distance_mm < math.inf or length < 20:
        raise BadInputError(
            f"the ruler's points are {length:.1f} pixels and {distance_mm:g} mm apart; "
            "choose two points at least 20 pixels apart and their distance in mm."
        )
    scale = length / distance_mm
    if scale > SCALE_MAX_PX_PER_MM:
        raise BadInputError(
            f"the ruler's {length:.0f} pixels are {distance_mm:g} mm, which is {scale:.3g} pixels "
            "a mm; is its length in mm?"
        )
    optics = Optics(
        image_size=image_size,
        date=str(date or dt.date.today()),  # noqa: DTZ011 - the day at the rig
        px_per_mm=scale,
        px_per_mm_sigma=scale * math.sqrt(2) * reading_sigma_px / length,
        roll_rad=0.0 if along_px is None else _direction_rad(clamp_px, along_px),
        clamp_angle_known=along_px is not None,
        clamp_px=clamp_px,
        method="ruler",
    )
    notes = ["a ruler gives the scale only: distortion and tilt of the camera stay in the curves"]
    if distance_mm < RULER_SHORT_MM:
        notes.append(
            f"the ruler is stated as {distance_mm:g} mm long, so a mm is {scale:.0f} pixels; is "
            "its length in mm?"
        )
    if along_px is None:
        notes.append(
            "the sheet's direction at the clamp is found in each image; a second pixel on the "
            "clamped sheet states it (--along-px U,V), and the x axis then runs along it"
        )
    return Calibration(
        optics=optics, residual_px=0.0, residual_um=0.0, largest_um=0.0, warnings=tuple(notes)
    )


def _direction_rad(first: Point, second: Point) -> float:
    return math.atan2(second[1] - first[1], second[0] - first[0])


def _check_clamp(clamp_px: Point, along_px: Point | None, size: tuple[int, int]) -> None:
    _inside(clamp_px, "clamp_px", size)
    if along_px is None:
        return
    _inside(along_px, "along_px", size)
    if math.dist(along_px, clamp_px) < CLAMP_DIRECTION_MIN_PX:
        raise BadInputError(
            f"along_px is {math.dist(along_px, clamp_px):.1f} pixels from clamp_px; choose a "
            "place on the clamped sheet's line at least "
            f"{CLAMP_DIRECTION_MIN_PX:g} pixels away."
        )


def _inside(place: Point, name: str, size: tuple[int, int]) -> None:
    found = outside(place, name, size)
    if found:
        raise BadInputError(f"{found}.")


def _common_size(images: Sequence[npt.NDArray[Any]]) -> tuple[int, int]:
    if not images:
        raise BadInputError("no image to calibrate from; give at least one of the board.")
    sizes = {(image.shape[1], image.shape[0]) for image in images}
    if len(sizes) > 1:
        listed = ", ".join(f"{w} x {h}" for w, h in sorted(sizes))
        raise BadInputError(
            f"the images differ in size ({listed}); take all with the same camera setting."
        )
    return sizes.pop()


def _lens_from_views(
    found: list[tuple[FloatArray, FloatArray]], camera: FloatArray, size: tuple[int, int]
) -> tuple[FloatArray, FloatArray]:
    import cv2

    solid = [np.column_stack([mm, np.zeros(len(mm))]).astype(np.float32) for mm, _ in found]
    seen = [px.astype(np.float32).reshape(-1, 1, 2) for _, px in found]
    flags = cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_FIX_K3 | cv2.CALIB_FIX_ASPECT_RATIO
    _, matrix, lens, _, _ = cv2.calibrateCamera(
        solid, seen, size, camera.copy(), np.zeros(5), flags=flags
    )
    return np.asarray(matrix, dtype=float), np.asarray(lens, dtype=float).ravel()[:5]


def _fit_plane(
    mm: FloatArray, px: FloatArray, camera: FloatArray, known: FloatArray, lens_sigma: FloatArray
) -> _PlaneFit:
    """Return the board's plane to undistorted pixels, and k1 and k2 as they are best in that plane.

    `lens_sigma` (2,): how far k1 and k2 may be from the known ones; k2 is never known well.
    """
    import cv2
    from scipy.optimize import least_squares

    start, _ = cv2.findHomography(mm, undistort(px, camera, known))
    start = np.asarray(start, dtype=float) / start[2, 2]

    def shown(p: FloatArray) -> FloatArray:
        bent = known.copy()
        bent[:2] = p[8:]
        return distort(project(np.append(p[:8], 1.0).reshape(3, 3), mm), camera, bent)

    # the entries of a homography differ by orders of magnitude
    typical = np.concatenate([np.abs(start.ravel()[:8]) + 1e-4, np.full(2, 0.1)])
    guess = np.concatenate([start.ravel()[:8], known[:2]])

    def misses(q: FloatArray) -> FloatArray:
        stray = (q[8:] * typical[8:] - known[:2]) * CORNER_SIGMA_PX / lens_sigma
        return np.concatenate([(shown(q * typical) - px).ravel(), stray])

    fit = least_squares(misses, guess / typical, method="lm")
    p = fit.x * typical
    homography = np.append(p[:8], 1.0).reshape(3, 3)
    bent = known.copy()
    bent[:2] = p[8:]
    residuals = fit.fun[:-2].reshape(-1, 2)
    variance = float((residuals**2).sum() / max(1, residuals.size - len(guess)))
    jacobian = np.asarray(fit.jac)
    covariance: FloatArray = np.linalg.pinv(jacobian.T @ jacobian) * variance
    return _PlaneFit(bent, homography, residuals, _scale_share(p, typical, covariance, mm))


def _scale_share(
    p: FloatArray, typical: FloatArray, covariance: FloatArray, mm: FloatArray
) -> float:
    """Return the scale's relative uncertainty in the board's middle, from the fit's covariance."""
    middle = mm.mean(axis=0)

    def log_scale(q: FloatArray) -> float:
        h = np.append((q * typical)[:8], 1.0).reshape(3, 3)
        return 0.5 * math.log(abs(np.linalg.det(plane_jacobian(h, middle))))

    at = p / typical
    steps = 1e-6 * np.eye(len(at))
    slope = np.array([(log_scale(at + s) - log_scale(at - s)) / 2e-6 for s in steps])
    return math.sqrt(max(0.0, float(slope @ covariance @ slope)))


def plane_jacobian(homography: FloatArray, point: FloatArray) -> FloatArray:
    """Return (2, 2): pixels per unit of the plane at a point."""
    step = 1e-4
    ends = project(homography, point + step * np.array([[1, 0], [-1, 0], [0, 1], [0, -1.0]]))
    return np.stack([ends[0] - ends[1], ends[2] - ends[3]], axis=1) / (2 * step)


def _as_calibration(
    fit: _PlaneFit,
    camera: FloatArray,
    size: tuple[int, int],
    clamp_px: Point,
    along_px: Point | None,
    board_scale_sigma: float,
    date: dt.date | None,
    views: int,
) -> Calibration:
    ahead = along_px or (clamp_px[0] + 0.1 * size[0], clamp_px[1])
    ideal = undistort(np.array([clamp_px, ahead]), camera, fit.lens)
    back = np.asarray(np.linalg.inv(fit.homography), dtype=np.float64)
    origin, second = project(back, ideal)
    axis = (second - origin) / math.dist(second, origin)
    # board axes: x right, y down as it lies; the world's y is up in the image
    handed = math.copysign(1.0, float(np.linalg.det(plane_jacobian(fit.homography, origin))))
    up = np.array([axis[1], -axis[0]]) * handed
    world = np.array([[axis[0], up[0], origin[0]], [axis[1], up[1], origin[1]], [0, 0, 1]])
    homography = fit.homography @ world
    homography /= homography[2, 2]
    here = plane_jacobian(homography, np.zeros(2))
    scale = math.sqrt(abs(float(np.linalg.det(here))))
    residual_px = float(np.sqrt((fit.residuals**2).sum(axis=1).mean()))
    if residual_px > CALIBRATION_RESIDUAL_MAX_PX:
        raise BadInputError(
            f"the board fits with {residual_px:.2f} pixels RMS, more than "
            f"{CALIBRATION_RESIDUAL_MAX_PX:g}; check that columns, rows and square size are "
            "those of this board and that it is flat."
        )
    per_um = 1000 / scale
    optics = Optics(
        image_size=size,
        date=str(date or dt.date.today()),  # noqa: DTZ011 - the day at the rig
        px_per_mm=scale,
        px_per_mm_sigma=scale * math.hypot(fit.scale_share, board_scale_sigma),
        roll_rad=math.atan2(here[1, 0], here[0, 0]),
        origin_px=(float(ideal[0, 0]), float(ideal[0, 1])),
        camera_matrix=_rows(camera),
        distortion=tuple(float(c) for c in fit.lens),
        homography=_rows(homography),
        clamp_px=(float(clamp_px[0]), float(clamp_px[1])),
        method=f"board, {views} image{'s' if views > 1 else ''}",
        residual_px=residual_px,
        residual_um=residual_px * per_um,
        views=views,
    )
    largest = float(np.hypot(*fit.residuals.T).max())
    warnings = _warnings(residual_px, homography, scale, size)
    if along_px is None:
        warnings += (ALONG_ROWS,)
    return Calibration(
        optics=optics,
        residual_px=residual_px,
        residual_um=residual_px * per_um,
        largest_um=largest * per_um,
        warnings=warnings,
    )


def _rows(matrix: FloatArray) -> Any:
    return tuple(tuple(float(c) for c in row) for row in matrix)


def _warnings(
    residual_px: float, homography: FloatArray, scale: float, size: tuple[int, int]
) -> tuple[str, ...]:
    out = []
    if residual_px > CALIBRATION_RESIDUAL_WARNED_PX:
        out.append(f"the board fits with {residual_px:.2f} pixels RMS; 0.1 is usual")
    change = math.hypot(homography[2, 0], homography[2, 1]) * size[0] / scale
    if change > 0.05:
        out.append(f"the camera is tilted: the scale changes by {change:.0%} over the image")
    return tuple(out)
