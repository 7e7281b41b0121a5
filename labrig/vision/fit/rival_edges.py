"""Find a second edge beside each edge of a strip: either may be the strip's own.

A tube in the light from one side shows the edge of its shade, too; a strip may have a shadow or a
neighbour. The image is looked at more finely than for the fit, for such edges are sharp.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.fit.outline import OutlineFit
from labrig.vision.fit.outline_profiles import (
    FINE_BLUR_RATIO,
    across_px,
    edge_sizes,
    running_middle,
)
from labrig.vision.image.image import GreyImage
from labrig.vision.thresholds import OUTLINE_STRENGTH_MIN_SIGMAS, RIVAL_EDGE_RATIOS

FloatArray = npt.NDArray[np.float64]

HALF_BLOCKS = 4  # to each side: an edge runs along the strip
NEAR_RATIO, NEAR_PX = 0.15, 0.5  # so near to the edge's place it is the edge itself
APART_RATIO, APART_PX = 0.2, 1.5  # so far from it an edge is another one
FARTHEST_RATIO = 1.25  # of the width, from the middle
OFTEN_SHARE = 0.25  # of the strip: a shorter rival is a crossing or a fitting


def rival_px(
    fit: OutlineFit, images: Sequence[GreyImage], optics: Optics
) -> tuple[FloatArray, FloatArray]:
    """Return (sides 2, nodes) how far outside of each edge another one lies, by its likelihood.

    0 where there is none; the whole distance where it is as clear as the edge itself. And (nodes,)
    the likelihood of one on either side, a crossing or a fitting included.
    """
    shape, blocks, width_px = fit.shape, fit.blocks, fit.width_px
    found, near = np.zeros((2, len(shape.x))), np.zeros(len(shape.x))
    many = max(1, int(np.median(np.diff(blocks.node))))
    across = across_px(width_px)
    size = edge_sizes(
        shape, images, optics, width_px, many, blur_ratio=FINE_BLUR_RATIO, taper=fit.taper
    )
    size = np.stack([running_middle(column, HALF_BLOCKS) for column in size.T], axis=1)
    half = 0.5 * _widths(fit) / fit.taper[blocks.node]
    for side, sign in enumerate((-1.0, 1.0)):
        out = sign * across - half[:, None]
        own = np.abs(out) < NEAR_RATIO * width_px + NEAR_PX
        beyond = (out > APART_RATIO * width_px + APART_PX) & (
            sign * across < FARTHEST_RATIO * width_px
        )
        there = np.where(beyond, size, 0.0)
        other = there.max(axis=1)
        ratio = other / np.maximum(np.where(own, size, 0.0).max(axis=1), 1e-9)
        least, most = RIVAL_EDGE_RATIOS
        likely = np.clip((ratio - least) / (most - least), 0.0, 1.0)
        likely = np.where(other > OUTLINE_STRENGTH_MIN_SIGMAS, likely, 0.0)
        near = np.maximum(near, np.interp(np.arange(len(shape.x)), blocks.node, likely))
        if (likely > 0).mean() < OFTEN_SHARE:
            continue
        apart = np.take_along_axis(out, there.argmax(axis=1)[:, None], axis=1)[:, 0]
        found[side] = np.interp(np.arange(len(shape.x)), blocks.node, likely * apart) * fit.taper
    return found, near


def _widths(fit: OutlineFit) -> FloatArray:
    """Return (blocks,) the strip's width there, from the blocks around that show both edges."""
    seen = fit.blocks.by_edges
    wide = running_middle(fit.blocks.width_px[seen], HALF_BLOCKS)
    return np.asarray(np.interp(fit.blocks.node, fit.blocks.node[seen], wide))
