"""A smooth curve along a path through stated places, where a thin strip's edges do not show it.

Noise and texture hide the edges of a strip that is a few pixels thick, block by block; the path
along which the image looks most like a strip, from one stated place to the next, follows it yet.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from labrig.vision.curve.shape import CurveShape
from labrig.vision.fit.outline import OutlineFit, smooth_fit
from labrig.vision.fit.outline_blocks import Blocks
from labrig.vision.fit.stated_places import StatedPlaces
from labrig.vision.search.straightened import distances, resampled
from labrig.vision.thresholds import PATH_SIGMA_MIN_PX, PATH_SIGMA_RATIO

FloatArray = npt.NDArray[np.float64]

ROUNDS = 4
BLOCK_MIN_PX = 3.0
OTHER_SHARE = 0.5  # of the distance to another path: so much of sigma


def fit_path(
    shape: CurveShape,
    path_px: FloatArray,
    *,
    width_px: float,
    clearness: float,
    prior: FloatArray,
    places: StatedPlaces,
    others_px: Sequence[FloatArray] = (),
) -> OutlineFit:
    """Return the curve beside a first one along a path (n, 2) in pixels of the sheet's plane.

    `others_px`: other paths through the same places. Where they part from it, one is wrong.
    """
    straight = np.ones(len(shape.x))
    for _ in range(ROUNDS):
        blocks = _blocks(shape, path_px, width_px, clearness)
        fit = smooth_fit(shape, blocks, prior, straight, places)
        shape = fit.shape
    nodes = np.stack([shape.x, shape.y], axis=1)
    apart = np.zeros(len(nodes))
    for other in others_px:
        along = resampled(other, BLOCK_MIN_PX)
        apart = np.maximum(apart, distances(nodes, along).min(axis=1))
    least = max(PATH_SIGMA_MIN_PX, PATH_SIGMA_RATIO * width_px)
    return fit.known_to(np.hypot(least, OTHER_SHARE * apart))


def _blocks(shape: CurveShape, path_px: FloatArray, width_px: float, clearness: float) -> Blocks:
    many = max(1, round(max(BLOCK_MIN_PX, width_px) / shape.basis.step_px))
    node = np.arange(many // 2, len(shape.x), many)
    x, y = shape.x[node, None], shape.y[node, None]
    nearest = np.hypot(path_px[:, 0] - x, path_px[:, 1] - y).argmin(axis=1)
    aside = path_px[nearest] - np.stack([shape.x[node], shape.y[node]], axis=1)
    sin, cos = np.sin(shape.phi[node]), np.cos(shape.phi[node])
    there = np.ones(len(node), dtype=bool)
    return Blocks(
        node=node.astype(np.int64),
        middle_px=cos * aside[:, 1] - sin * aside[:, 0],
        width_px=np.full(len(node), width_px),
        strength=np.full(len(node), clearness),
        clear=there,
        seen=there,
        by_profile=~there,
    )
