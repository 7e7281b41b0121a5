"""Dijkstra's shortest path over the pixels of a map, compiled.

Steps go to the eight neighbours; one costs its length times the mean cost of both pixels.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from labrig.vision.jit import jit, jit_inside

MapArray = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]

NEIGHBOURS = 8
DIAGONAL = math.sqrt(2.0)  # a step's length


@jit_inside
def _push(keys: FloatArray, items: IntArray, size: int, key: float, item: int) -> int:
    """Put an item into a heap whose first has the least key; return its new size."""
    at = size
    while at > 0 and keys[(at - 1) // 2] > key:
        keys[at], items[at] = keys[(at - 1) // 2], items[(at - 1) // 2]
        at = (at - 1) // 2
    keys[at], items[at] = key, item
    return size + 1


@jit_inside
def _pop(keys: FloatArray, items: IntArray, size: int) -> int:
    """Take the first item out of a heap; return its new size."""
    size -= 1
    key, item = keys[size], items[size]
    at = 0
    while 2 * at + 1 < size:
        below = 2 * at + 1
        if below + 1 < size and keys[below + 1] < keys[below]:
            below += 1
        if keys[below] >= key:
            break
        keys[at], items[at] = keys[below], items[below]
        at = below
    keys[at], items[at] = key, item
    return size


@jit
def shortest_path(cost: MapArray, first: int, last: int) -> IntArray:
    """Return the pixels (flat indices) of the cheapest path through `cost` (rows, columns).

    `cost`: above 0 everywhere, so that every pixel is reached. From `first` to `last`, both in it.
    """
    rows, columns = cost.shape
    so_far = np.full(rows * columns, np.inf)
    came = np.full(rows * columns, -1, dtype=np.int64)
    keys, items = np.empty(NEIGHBOURS), np.empty(NEIGHBOURS, dtype=np.int64)  # they grow
    so_far[first] = 0.0
    size = _push(keys, items, 0, 0.0, first)
    while size > 0:
        key, at = keys[0], items[0]
        size = _pop(keys, items, size)
        if at == last:
            break
        if key > so_far[at]:
            continue  # a cheaper way was found since
        if size + NEIGHBOURS > len(keys):
            keys = np.concatenate((keys, np.empty_like(keys)))
            items = np.concatenate((items, np.empty_like(items)))
        row, column = at // columns, at % columns
        for i in range(max(0, row - 1), min(rows, row + 2)):
            for j in range(max(0, column - 1), min(columns, column + 2)):
                length = 1.0 if i == row or j == column else DIAGONAL
                total = key + 0.5 * length * (cost[row, column] + cost[i, j])
                there = i * columns + j
                if total < so_far[there]:
                    so_far[there], came[there] = total, at
                    size = _push(keys, items, size, total, there)
    many = 1
    at = last
    while at != first:
        at = came[at]
        many += 1
    path = np.empty(many, dtype=np.int64)
    at = last
    for k in range(many - 1, -1, -1):
        path[k] = at
        at = came[at]
    return path
