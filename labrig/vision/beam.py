"""Beam search: the likeliest path of a thin band from the clamp, through gaps and past crossings.

A state is a place, a direction and a bend; each step adds what the ridge maps say along it. Only
bends near the last one are tried, so a path is what a sheet can do; the straight rest of a short
sheet has no bend at all. Runs in raw pixels (u right, v down).
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from labrig.vision._jit import jit

FloatArray = npt.NDArray[np.float64]
MapArray = npt.NDArray[np.float32]

TURN = 0.012  # rad: bends come in this quantum a step
PER_STEP = 3  # samples of the maps a step


@jit
def ridge_score(
    maps: MapArray,
    sign: float,
    u: float,
    v: float,
    c: float,
    s: float,
    layers: int,
    half: float,
) -> float:
    """How much the place looks like a band's ridge in direction (c, s): -0.3 .. 1.

    `maps` (layers, rows, columns, 5): second derivatives uu, uv, vv and the slope's u, v parts,
    in units of their noise. A step edge bends as well as a ridge does, but it slopes too.
    """
    rows, columns = maps.shape[1], maps.shape[2]
    i, j = int((v + 0.5) // 1), int((u + 0.5) // 1)
    if i < 0 or j < 0 or i >= rows or j >= columns:
        return -0.3
    best = -1e9
    for layer in range(layers):
        m = maps[layer, i, j]
        bend = -sign * (s * s * m[0] - 2 * s * c * m[1] + c * c * m[2])
        slope = abs(-s * m[3] + c * m[4])
        best = max(best, bend - 0.7 * slope)
    if best <= 0:
        return max(-0.3, 0.06 * best)
    return best / (best + half)


@jit
def search(
    maps: MapArray,
    sign: float,
    u0: float,
    v0: float,
    heading: float,
    spread: FloatArray,
    steps: int,
    straight_from: int,
    wide_from: int,
    length: float,
    most_bend: int,
    most_turn: float,
    width: int,
    half: float,
) -> tuple[FloatArray, FloatArray, float]:
    """The best path of `steps` steps: nodes (steps + 1, 2) and the score of each step (steps,), and their mean.

    `spread` (n, 2): offsets along the normal and angles at which paths may start. `most_bend` in
    quanta a step, `most_turn` in rad from the start; `width` states are kept after each step.
    """
    starts = len(spread)
    capacity = max(width, starts * (2 * most_bend + 1))
    state = np.empty((capacity, 5))  # u, v, angle, score, start angle
    bend = np.zeros(capacity, dtype=np.int64)
    parent = np.zeros((steps, width), dtype=np.int64)
    log_u = np.empty((steps + 1, width))
    log_v = np.empty((steps + 1, width))
    log_gain = np.zeros((steps + 1, width))
    child = np.empty((capacity * 5 + 5, 5))
    child_bend = np.zeros(capacity * 5 + 5, dtype=np.int64)
    child_of = np.zeros(capacity * 5 + 5, dtype=np.int64)
    child_gain = np.zeros(capacity * 5 + 5)
    alive = 0
    for a in range(starts):
        angle = heading + spread[a, 1]
        for b in range(-most_bend, most_bend + 1):
            if straight_from == 0 and b != 0:
                continue
            state[alive, 0] = u0 - math.sin(heading) * spread[a, 0]
            state[alive, 1] = v0 + math.cos(heading) * spread[a, 0]
            state[alive, 2] = angle
            state[alive, 3] = -0.02 * abs(spread[a, 0])
            state[alive, 4] = angle
            bend[alive] = b
            alive += 1
    step_back = np.zeros(capacity, dtype=np.int64)
    first_u = state[:alive, 0].copy()
    first_v = state[:alive, 1].copy()
    first_of = np.zeros((width,), dtype=np.int64)
    for j in range(steps):
        layers = maps.shape[0] if j >= wide_from else 1
        many = 0
        for a in range(alive):
            for change in range(-2, 3):
                b = bend[a] + change
                turn = b * TURN
                if j == 0 and change != 0:
                    continue
                if j >= straight_from:
                    # no bend, but room to correct the quantum of the angles before
                    b = 0
                    turn = 0.4 * change * TURN
                if abs(b) > most_bend:
                    continue
                angle = state[a, 2] + turn
                if abs(angle - state[a, 4]) > most_turn:
                    continue
                gain = 0.0
                u, v = state[a, 0], state[a, 1]
                for q in range(PER_STEP):
                    part = state[a, 2] + turn * (q + 0.5) / PER_STEP
                    c, s = math.cos(part), math.sin(part)
                    u += c * length / PER_STEP
                    v += s * length / PER_STEP
                    gain += ridge_score(maps, sign, u, v, c, s, layers, half)
                gain = gain / PER_STEP - (0.01 if j < straight_from else 0.002) * change * change
                child[many, 0] = u
                child[many, 1] = v
                child[many, 2] = angle
                child[many, 3] = state[a, 3] + gain
                child[many, 4] = state[a, 4]
                child_bend[many] = b
                child_of[many] = a
                child_gain[many] = gain
                many += 1
        if many == 0:
            return np.empty((0, 2)), np.empty(0), -1.0
        # a straight rest differs in little but its angle
        fine = 0.1 if j < straight_from else 0.006
        order = np.argsort(-child[:many, 3])
        kept = 0
        cells = np.zeros(8192, dtype=np.int64)
        for o in range(many):
            if kept >= width:
                break
            t = order[o]
            # few states of one place and direction, so that the beam stays broad
            key = (
                int(child[t, 0] // 2.0) * 73856093
                ^ int(child[t, 1] // 2.0) * 19349663
                ^ int(child[t, 2] // fine) * 83492791
                ^ int(child_bend[t] // 3) * 49979687
            ) & 8191
            if cells[key] >= 2:
                continue
            cells[key] += 1
            for q in range(5):
                state[kept, q] = child[t, q]
            step_back[kept] = child_of[t]
            bend[kept] = child_bend[t]
            log_u[j + 1, kept] = child[t, 0]
            log_v[j + 1, kept] = child[t, 1]
            log_gain[j + 1, kept] = child_gain[t]
            kept += 1
        if j == 0:
            for a in range(kept):
                first_of[a] = step_back[a]
                parent[j, a] = a
        else:
            for a in range(kept):
                parent[j, a] = step_back[a]
        alive = kept
    path = np.empty((steps + 1, 2))
    gains = np.empty(steps)
    at = 0
    for j in range(steps, 0, -1):
        path[j, 0] = log_u[j, at]
        path[j, 1] = log_v[j, at]
        gains[j - 1] = log_gain[j, at]
        if j > 1:
            at = parent[j - 1, at]
        else:
            path[0, 0] = first_u[first_of[at]]
            path[0, 1] = first_v[first_of[at]]
    return path, gains, float(gains.mean())
