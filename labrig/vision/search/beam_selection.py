"""Which states of a beam are kept after a step, compiled."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from labrig.vision.jit import jit, jit_inside

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

U, V, ANGLE, SCORE, FIRST, GAIN = 0, 1, 2, 3, 4, 5  # columns of a state
KINDS = 8192  # of place, direction and bend, that are told apart: a power of 2


@jit
def select(
    child: FloatArray,
    child_bend: IntArray,
    count: int,
    width: int,
    fine: float,
    chosen: IntArray,
    best_two: IntArray,
) -> int:
    """Choose the best children, at most two of one place, direction and bend; return how many.

    So the beam stays broad. The best one comes first, the others in no order. `best_two` (KINDS,
    2): room for the best two of each kind, -1 everywhere, and again afterwards.
    """
    kind = np.empty(count, dtype=np.int64)
    for t in range(count):
        key = (
            math.floor(child[t, U] / 2.0) * 73856093
            ^ math.floor(child[t, V] / 2.0) * 19349663
            ^ math.floor(child[t, ANGLE] / fine) * 83492791
            ^ int(child_bend[t] // 3) * 49979687
        ) & (KINDS - 1)
        kind[t] = key
        one, two = best_two[key, 0], best_two[key, 1]
        if one < 0 or child[t, SCORE] > child[one, SCORE]:
            best_two[key, 0], best_two[key, 1] = t, one
        elif two < 0 or child[t, SCORE] > child[two, SCORE]:
            best_two[key, 1] = t
    kept, places = np.empty(count, dtype=np.int64), 0
    for t in range(count):
        if best_two[kind[t], 0] == t or best_two[kind[t], 1] == t:
            kept[places] = t
            places += 1
    for t in range(count):
        best_two[kind[t], 0] = best_two[kind[t], 1] = -1
    if places > width:
        _best_first(kept, places, width, child)
        places = width
    for i in range(places):
        if child[kept[i], SCORE] > child[kept[0], SCORE]:
            kept[0], kept[i] = kept[i], kept[0]
    for i in range(places):
        chosen[i] = kept[i]
    return places


@jit_inside
def _best_first(rows: IntArray, count: int, width: int, child: FloatArray) -> None:
    """Order rows so that the first `width` of them are the best ones (Hoare's quickselect)."""
    low, high = 0, count - 1
    while low < high:
        middle = child[rows[(low + high) // 2], SCORE]
        i, j = low, high
        while i <= j:
            while child[rows[i], SCORE] > middle:
                i += 1
            while child[rows[j], SCORE] < middle:
                j -= 1
            if i <= j:
                rows[i], rows[j] = rows[j], rows[i]
                i, j = i + 1, j - 1
        if width - 1 <= j:
            high = j
        elif width - 1 >= i:
            low = i
        else:
            break
