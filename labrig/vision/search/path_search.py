"""Beam search: the likeliest path of a thin band from the clamp, through gaps and past crossings.

A state is a place, a direction and a bend; each step adds the ridge maps' score along it. Only
bends near the last one are tried, so a path is what a sheet can do; the straight rest of a short
sheet has no bend at all. Runs in raw pixels (u right, v down).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.jit import jit, jit_inside
from labrig.vision.search.beam_selection import (
    ANGLE,
    FIRST,
    GAIN,
    KINDS,
    SCORE,
    U,
    V,
    select,
)

FloatArray = npt.NDArray[np.float64]
MapArray = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int64]

BEND_QUANTUM_RAD = 0.012  # rad: bends come in this quantum a step
SAMPLES_PER_STEP = 2  # samples of the maps a step


@jit_inside
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
    """Return how much the place looks like a band's ridge in direction (c, s): -0.3 .. 1.

    `maps` (layers, 5, rows, columns): second derivatives uu, uv, vv and the slope's u, v parts,
    in units of their noise. A step edge bends as well as a ridge does, but it slopes too.
    """
    rows, columns = maps.shape[2], maps.shape[3]
    i, j = math.floor(v + 0.5), math.floor(u + 0.5)
    if i < 0 or j < 0 or i >= rows or j >= columns:
        return -0.3
    best = -1e9
    for layer in range(layers):
        uu, uv, vv = maps[layer, 0, i, j], maps[layer, 1, i, j], maps[layer, 2, i, j]
        bend = -sign * (s * s * uu - 2 * s * c * uv + c * c * vv)
        slope = abs(-s * maps[layer, 3, i, j] + c * maps[layer, 4, i, j])
        best = max(best, bend - 0.7 * slope)
    if best <= 0:
        return max(-0.3, 0.06 * best)
    return best / (best + half)


@jit_inside
def _step_along(
    maps: MapArray,
    sign: float,
    u: float,
    v: float,
    cos: float,
    sin: float,
    turn: float,
    length: float,
    layers: int,
    half: float,
) -> tuple[float, float, float]:
    """Return one step from a direction (cos, sin): where it ends, and how ridge-like it was."""
    gain = 0.0
    for q in range(SAMPLES_PER_STEP):
        part = turn * (q + 0.5) / SAMPLES_PER_STEP
        # a step turns by less than half a radian: these are good to 1e-7
        p2 = part * part
        dc = 1 - p2 * (1 / 2 - p2 * (1 / 24 - p2 / 720))
        ds = part * (1 - p2 * (1 / 6 - p2 * (1 / 120 - p2 / 5040)))
        c, s = cos * dc - sin * ds, sin * dc + cos * ds
        u += c * length / SAMPLES_PER_STEP
        v += s * length / SAMPLES_PER_STEP
        gain += ridge_score(maps, sign, u, v, c, s, layers=layers, half=half)
    return u, v, gain / SAMPLES_PER_STEP


@jit
def _start(
    state: FloatArray,
    bend: IntArray,
    u0: float,
    v0: float,
    heading: float,
    spread: FloatArray,
    most_bend: int,
) -> int:
    """Fill in every start with every bend; their number."""
    alive = 0
    for a in range(len(spread)):
        for b in range(-most_bend, most_bend + 1):
            beside = heading + spread[a, 2]
            state[alive, U] = u0 - math.sin(beside) * spread[a, 0]
            state[alive, V] = v0 + math.cos(beside) * spread[a, 0]
            state[alive, ANGLE] = heading + spread[a, 1]
            state[alive, SCORE] = -0.02 * abs(spread[a, 0])
            state[alive, FIRST] = heading + spread[a, 1]
            bend[alive] = b
            alive += 1
    return alive


@jit
def _expand(
    maps: MapArray,
    sign: float,
    state: FloatArray,
    bend: IntArray,
    alive: int,
    child: FloatArray,
    child_bend: IntArray,
    child_of: IntArray,
    changes: int,
    straight: bool,
    layers: int,
    length: float,
    most_bend: int,
    most_turn: float,
    half: float,
    quantum: float,
) -> int:
    """Return all children of the living states; their number."""
    count = 0
    cost = 0.002 if straight else 0.01
    for a in range(alive):
        cos, sin = math.cos(state[a, ANGLE]), math.sin(state[a, ANGLE])
        for change in range(-changes, changes + 1):
            # a straight rest has no bend, but room to correct the quantum of the angles before
            b = 0 if straight else bend[a] + change
            turn = 0.4 * change * quantum if straight else b * quantum
            angle = state[a, ANGLE] + turn
            if abs(b) > most_bend or abs(angle - state[a, FIRST]) > most_turn:
                continue
            u, v, gain = _step_along(
                maps,
                sign,
                state[a, U],
                state[a, V],
                cos=cos,
                sin=sin,
                turn=turn,
                length=length,
                layers=layers,
                half=half,
            )
            gain -= cost * change * change
            child[count, U], child[count, V], child[count, ANGLE] = u, v, angle
            child[count, SCORE] = state[a, SCORE] + gain
            child[count, FIRST] = state[a, FIRST]
            child[count, GAIN] = gain
            child_bend[count], child_of[count] = b, a
            count += 1
    return count


@dataclass(frozen=True, eq=False)
class Beam:
    """The states that were kept after each step, the best one first."""

    start: FloatArray  # (states, 2)
    log: FloatArray  # (steps, width, 3): where each is, and the score of the step to it
    parent: IntArray  # (steps, width): the state of the step before

    def best(self, steps: int | None = None) -> tuple[FloatArray, FloatArray]:
        """Return the best path of the first steps, or of all: nodes (steps + 1, 2), and scores.

        Empty ones where every path left what a sheet can do.
        """
        many = len(self.log) if steps is None else steps
        if many == 0:
            return np.empty((0, 2)), np.empty(0)
        state = np.zeros(many + 1, dtype=np.int64)
        for j in range(many - 1, -1, -1):
            state[j] = self.parent[j, state[j + 1]]
        seen = self.log[np.arange(many), state[1:]]
        return np.concatenate([self.start[state[:1]], seen[:, :2]]), seen[:, 2]


def search(
    maps: MapArray,
    sign: float,
    *,
    place: tuple[float, float],
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
    quantum: float = BEND_QUANTUM_RAD,
) -> Beam:
    """Return all paths that are kept from a place (u, v) of the maps on.

    `spread` (n, 3): offsets and angles at which paths may start, and the angle to whose left an
    offset is; angles from `heading`. `most_bend` in quanta (rad) a step, `most_turn` in rad from
    the start; `width` states are kept after each step. From step `straight_from` on there is no
    bend, from `wide_from` on all layers of the maps count.
    """
    return Beam(
        *_grow(
            maps,
            sign,
            u0=float(place[0]),
            v0=float(place[1]),
            heading=heading,
            spread=spread,
            steps=steps,
            straight_from=straight_from,
            wide_from=wide_from,
            length=length,
            most_bend=most_bend,
            most_turn=most_turn,
            width=width,
            half=half,
            quantum=quantum,
        )
    )


@jit
def _grow(
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
    quantum: float,
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return start, log and parents of a beam; see `search`. No step where none is possible."""
    capacity = max(width, len(spread) * (2 * most_bend + 1))
    state, bend = np.empty((capacity, 5)), np.zeros(capacity, dtype=np.int64)
    child = np.empty((5 * capacity, 6))
    child_bend = np.zeros(5 * capacity, dtype=np.int64)
    child_of = np.zeros(5 * capacity, dtype=np.int64)
    parent = np.zeros((steps, width), dtype=np.int64)
    log, chosen = np.empty((steps, width, 3)), np.empty(width, dtype=np.int64)
    best_two = np.full((KINDS, 2), -1, dtype=np.int64)
    alive = _start(state, bend, u0, v0, heading, spread, most_bend)
    start = np.empty((alive, 2))
    for i in range(alive):
        start[i, U], start[i, V] = state[i, U], state[i, V]
    for j in range(steps):
        straight = j >= straight_from
        layers = maps.shape[0] if j >= wide_from else 1
        changes = 0 if j == 0 else 2
        count = _expand(
            maps,
            sign,
            state,
            bend,
            alive=alive,
            child=child,
            child_bend=child_bend,
            child_of=child_of,
            changes=changes,
            straight=straight,
            layers=layers,
            length=length,
            most_bend=most_bend,
            most_turn=most_turn,
            half=half,
            quantum=quantum,
        )
        if count == 0:
            return start, log[:0], parent[:0]
        # a straight rest differs in little but its angle
        fine = 0.006 if straight else 0.1
        alive = select(child, child_bend, count, width, fine, chosen, best_two)
        for i in range(alive):
            t = chosen[i]
            for q in range(5):
                state[i, q] = child[t, q]
            bend[i], parent[j, i] = child_bend[t], child_of[t]
            log[j, i, 0], log[j, i, 1], log[j, i, 2] = child[t, U], child[t, V], child[t, GAIN]
    return start, log, parent
