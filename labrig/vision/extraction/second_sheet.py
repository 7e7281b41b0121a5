"""Whether a second sheet leaves the clamp beside the one that was found."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from labrig.vision.extraction.curve_search import CurveSearch
from labrig.vision.extraction.refinement import CurveCandidate
from labrig.vision.search.ridge_tracing import trace_from_clamp
from labrig.vision.thresholds import (
    SECOND_SHEET_SCORE_MIN,
)

FloatArray = npt.NDArray[np.float64]

CLAMP_OFFSETS_SIGMAS = (-12.0, -9.0, -6.0, -3.0, 0.0, 3.0, 6.0, 9.0, 12.0)


def second_sheet_contrast(search: CurveSearch, found: CurveCandidate) -> float:
    """Return the contrast of a second sheet from the clamp over the first's; 0 without one.

    The second may leave the clamp or a place close beside it.
    """
    nodes = found.context.nodes_px(found.fit.shape)
    half = float(found.fit.section.half_width.max())
    # at the clamp two sheets are one
    apart_from = len(nodes) // 12
    sign, optics, ridges = found.context.sign, search.optics, search.ridges
    with ridges.without(nodes[apart_from:], 2 + half + found.fit.section.blur):
        other = trace_from_clamp(
            ridges, optics, search.strip, sign, width=40, share=0.5, offsets=CLAMP_OFFSETS_SIGMAS
        )
        if other is None or other.score < SECOND_SHEET_SCORE_MIN:
            return 0.0
        # only now is the whole of it worth a fit; its own start stands for the clamp
        start = (float(other.path[0, 0]), float(other.path[0, 1]))
        moved = optics.model_copy(update={"clamp_px": start})
        trace = trace_from_clamp(ridges, moved, search.strip, sign, width=120)
    if trace is None:
        return 0.0
    other_search = CurveSearch(search.image, moved, search.strip)
    second = other_search.refine(trace, sign)
    apart = _distance(second, nodes).max()
    if not second.confirmed or second.verdict.covered <= 0.8 or apart <= 4:
        return 0.0
    return second.fit.usual_contrast / found.fit.usual_contrast


def _distance(candidate: CurveCandidate, nodes: FloatArray) -> FloatArray:
    """Return (nodes,) distance in the image, point by point along both curves."""
    gap = candidate.context.nodes_px(candidate.fit.shape) - nodes
    return np.asarray(np.hypot(gap[:, 0], gap[:, 1]))
