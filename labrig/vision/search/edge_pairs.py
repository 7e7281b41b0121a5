"""The clearest pair of edges along a straightened strip, compiled: block by block up to its end."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from labrig.vision.jit import jit

FloatArray = npt.NDArray[np.float64]

OUTLIER_RATIO = 2.0  # of a block's edges to the usual ones: more does not count


@jit
def edge_pairs(
    slope: FloatArray,
    apart: float,
    reach: int,
    opposite: bool,
    run_blocks: int,
    run_share: float,
    present_ratio: float,
) -> tuple[float, FloatArray]:
    """Return how much a pair of edges `apart` columns from each other shows, and (blocks,) each.

    `slope` (blocks, across): the pair may lie up to `reach` columns beside the middle; the weaker
    edge counts. `opposite`: only a rise with a fall, for two places on one blurred edge are no
    pair. Up to the strip's end its edges are there, beyond it they are not (less than
    `present_ratio` of the usual ones): the place where that is truest, before they are missing for
    more than `run_blocks` and `run_share` of the way.
    """
    blocks, columns = slope.shape
    middle = columns // 2
    edges = np.zeros(blocks)
    for shift in range(-reach, reach + 1):
        low = min(max(round(middle + shift - apart / 2), 0), columns - 1)
        high = min(max(round(middle + shift + apart / 2), 0), columns - 1)
        for b in range(blocks):
            one, other = slope[b, low], slope[b, high]
            if opposite and one * other >= 0:
                continue
            edges[b] = max(edges[b], min(abs(one), abs(other)))
    usual = max(np.median(edges[: max(run_blocks, blocks // 8)]), 1e-9)
    total, most, end, seen = 0.0, -1e300, 0, -1
    for b in range(blocks):
        there = min(edges[b] / usual, 1.0) - present_ratio
        total += there
        if total > most:
            most, end = total, b + 1
        if there > 0:
            seen = b
        elif b - seen > max(run_blocks, run_share * b):
            break
    edges = edges[:end]
    limit = OUTLIER_RATIO * np.median(edges)
    shown = 0.0
    for edge in edges:
        shown += min(edge, limit)
    return shown, edges
