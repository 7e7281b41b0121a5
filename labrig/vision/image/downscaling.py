"""Downscale the image of a thick strip, so that the fit sees a strip of about four pixels.

What the fit knows of a sheet's looks is in pixels of one a few pixels thick: how far along it light
and width stay the same, how far beside it something else may lie. A strip that fills more pixels
shows its texture and its frayed edges instead, and tells hardly better where its middle is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve import NeutralCurve
from labrig.vision.curve.background_lines import BackgroundLine
from labrig.vision.facts.stated import moved
from labrig.vision.image.image import GreyImage, pixel_noise
from labrig.vision.thresholds import DOWNSCALED_THICKNESS_PX, FULL_RESOLUTION_THICKNESS_MAX_PX

FloatArray = npt.NDArray[np.float64]


def downscaling_factor(thickness_px: float) -> int:
    """Return how many times an image is reduced for a strip of this thickness."""
    return (
        round(thickness_px / DOWNSCALED_THICKNESS_PX)
        if thickness_px > FULL_RESOLUTION_THICKNESS_MAX_PX
        else 1
    )


def downscaled_image(image: GreyImage, by: float) -> GreyImage:
    """Return the means of squares of pixels, with parts of those at their borders."""
    import cv2

    rows, columns = (int(each / by) for each in image.grey.shape)
    whole = image.grey[: round(rows * by), : round(columns * by)]
    grey = np.asarray(cv2.resize(whole, (columns, rows), interpolation=cv2.INTER_AREA))
    noise = pixel_noise(grey, image.full_scale)
    return replace(image, grey=grey, noise=noise, downscaling=by, full_resolution=image.grey)


def downscaled_optics(optics: Optics, by: float) -> Optics:
    """Return what a camera with pixels `by` times as large has for a calibration."""
    small = np.array([[1 / by, 0, 0.5 / by - 0.5], [0, 1 / by, 0.5 / by - 0.5], [0, 0, 1.0]])

    def point(place: tuple[float, float]) -> tuple[float, float]:
        return scaled_place(place, 1 / by)

    changed: dict[str, object] = {
        "px_per_mm": optics.px_per_mm / by,
        "px_per_mm_sigma": optics.px_per_mm_sigma / by,
        "clamp_px": point(optics.clamp_px),
        "clamp_sigma_px": optics.clamp_sigma_px / by,
        "origin_sigma_px": optics.origin_sigma_px / by,
        "image_size": None,
    }
    if optics.origin_px is not None:
        changed["origin_px"] = point(optics.origin_px)
    for name in ("camera_matrix", "homography"):
        matrix = getattr(optics, name)
        if matrix is not None:
            changed[name] = tuple(tuple(row) for row in (small @ np.array(matrix)).tolist())
    if optics.rolls_px is not None:
        changed["rolls_px"] = tuple((*point((u, v)), r / by) for u, v, r in optics.rolls_px)
    changed["facts"] = moved(optics.facts, point)
    return optics.model_copy(update=changed)


def scaled_places(places: FloatArray, by: float) -> FloatArray:
    """Return pixels (..., 2) in an image `by` times as large.

    A pixel's centre is an integer in both.
    """
    return np.asarray((places + 0.5) * by - 0.5)


def scaled_place(place: tuple[float, float], by: float) -> tuple[float, float]:
    """Return one pixel in an image `by` times as large."""
    u, v = scaled_places(np.array(place), by)
    return float(u), float(v)


def scaled_curve(curve: NeutralCurve, by: float) -> NeutralCurve:
    """Return a curve whose lengths in pixels are those of an image `by` times as large."""
    at = curve.refused_at_px
    return replace(
        curve,
        refused_at_px=None if at is None else scaled_place(at, by),
        points_px=scaled_places(curve.points_px, by),
        residual_px=curve.residual_px * by,
        blur_px=curve.blur_px * by,
        elongation_width_px=curve.elongation_width_px * by,
        excess_px=curve.excess_px * by,
        lateral_bias_px=curve.lateral_bias_px * by,
        side_face_px=curve.side_face_px * by,
        wires=tuple(
            BackgroundLine(scaled_places(wire.path, by), wire.seen, wire.half_px * by)
            for wire in curve.wires
        ),
    )


def in_camera_pixels(curve: NeutralCurve, by: float) -> NeutralCurve:
    """Return a curve found in a downscaled image, for who knows the whole one only."""
    note = f"pixels here are those of the image downscaled {by:.3g} times"

    def noted(text: str) -> str:
        if "pixel" not in text:
            return text
        return f"{text[:-1]} ({note})." if text.endswith(".") else f"{text} ({note})"

    whole = scaled_curve(curve, by)
    return replace(whole, why=noted(curve.why), warnings=tuple(map(noted, curve.warnings)))
