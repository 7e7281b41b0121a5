"""Structures beside a curve, found in the image straightened along it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from labrig.vision.fit.context import FitContext
from labrig.vision.fit.curve_fit import CurveFit
from labrig.vision.thresholds import EDGE_STEP_MAX_RATIO, OPPOSITE_CONTRAST_MAX_RATIO

FloatArray = npt.NDArray[np.float64]

PROFILE_PIECES = 6
# from the sheet's blurred edge: what a narrow thing beside it does not reach
EDGE_DISTANCES_PX = (4.0, 9.0)


def straightened(fit: CurveFit, context: FitContext, across: FloatArray) -> FloatArray:
    """Return (nodes, offsets) intensities at distances `across` (pixels) from the curve.

    NaN outside.

    Of every third node, which is enough for medians.
    """
    import cv2

    shape, some = fit.shape, slice(None, None, 3)
    x = shape.x[some, None] - np.sin(shape.phi[some])[:, None] * across
    y = shape.y[some, None] + np.cos(shape.phi[some])[:, None] * across
    plane = np.stack([x.ravel(), y.ravel()], axis=1) / context.optics.px_per_m
    uv = context.optics.world_to_pixel(plane).astype(np.float32).reshape(*x.shape, 2)
    return np.asarray(
        cv2.remap(
            context.image.grey,
            uv[..., 0],
            uv[..., 1],
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=float("nan"),
        ),
        dtype=float,
    )


def runs_beside_opposite(fit: CurveFit, context: FitContext) -> bool:
    """Return whether a stronger band of the opposite sign accompanies the curve.

    A bright sheet's dark flank looks like a thin dark sheet to a filter, and the other way round.
    """
    half = float(fit.section.half_width.max())
    reach = round(2 * half + 3 * fit.section.blur + 5)
    across = np.arange(-reach, reach + 1, dtype=float)
    strip = straightened(fit, context, across)
    profiles = []
    for piece in np.array_split(np.arange(len(strip)), PROFILE_PIECES):
        rows = strip[piece][np.isfinite(strip[piece]).all(axis=1)]
        if len(rows) < 2:
            continue
        profiles.append(np.median(rows, axis=0))
    if not profiles:
        return False
    # other things of the sheet's own sign, such as rolls, may fill nearly half the profile
    ground = np.percentile(profiles, 60 if context.sign < 0 else 40, axis=1)
    opposite = (-context.sign * (np.array(profiles) - ground[:, None])).max(axis=1)
    votes = np.count_nonzero(opposite > OPPOSITE_CONTRAST_MAX_RATIO * fit.usual_contrast)
    return bool(votes >= PROFILE_PIECES // 2)


def is_an_edge(fit: CurveFit, context: FitContext) -> bool:
    """Return whether one side of the curve is as bright as the curve itself.

    The edge of something wide.

    The side face of a silhouette is that too, but not as wide.
    """
    if not fit.used.any():
        return False
    side_face = (
        float(np.abs(fit.section.side_face).max()) if fit.section.side_face_share > 0 else 0.0
    )
    near = float(fit.section.half_width.max()) + 2.5 * fit.section.blur + side_face
    across = near + np.linspace(*EDGE_DISTANCES_PX, 4)
    strip = straightened(fit, context, np.concatenate([-across, across]))
    votes = 0
    for piece in np.array_split(np.arange(len(strip)), PROFILE_PIECES):
        rows = strip[piece][np.isfinite(strip[piece]).all(axis=1)]
        if len(rows) >= 2:
            below, above = (float(np.median(side)) for side in np.array_split(rows, 2, axis=1))
            votes += int(abs(above - below) > EDGE_STEP_MAX_RATIO * fit.usual_contrast)
    return votes > PROFILE_PIECES // 2
