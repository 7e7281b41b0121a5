"""Find straight ridges: where they cross a ring of places, and how far each can be followed."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from labrig.vision.jit import jit
from labrig.vision.search.path_search import ridge_score
from labrig.vision.thresholds import (
    LINE_BEGIN_SCORE_MIN,
    LINE_SCORE_MIN,
    LINE_SEEN_SCORE_MIN,
    RIDGE_BEND_MIN_SIGMAS,
)

FloatArray = npt.NDArray[np.float64]
MapArray = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

BEND_AT_HALF_SCORE = 4.0  # a ridge that bends by this scores a half
# about the direction that one place of the ring shows
TRIED_TURNS_RAD = np.linspace(-0.45, 0.45, 37)
BEGIN_LENGTH_PX = 10.0  # a sheet ends further than that from the border
FIRST_LENGTH_PX, STEP_PX, CORRIDOR_PX = 60.0, 2.0, 4
ENTRIES_MAX = 10  # on a ring
BOW_SIGMA_PX = 10.0  # how far from straight the lens may make it
PIECE_STEPS = 10


@jit
def _bends(layer: MapArray, sign: float, u: IntArray, v: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return how much a ridge the places are in whichever direction, and that direction."""
    bend, angle = np.empty(len(u)), np.empty(len(u))
    for i in range(len(u)):
        m = layer[:, v[i], u[i]]
        gap, mean = 0.5 * (m[0] - m[2]), 0.5 * (m[0] + m[2])
        across = 0.5 * math.atan2(m[1], gap) + (math.pi / 2 if sign > 0 else 0.0)
        slope = abs(m[3] * math.cos(across) + m[4] * math.sin(across))
        bend[i] = math.hypot(gap, m[1]) - sign * mean - 0.7 * slope
        angle[i] = across + math.pi / 2
    return bend, angle


def entries(layer: MapArray, sign: float, u: IntArray, v: IntArray) -> FloatArray:
    """Return (n, 3) where ridges cross a closed ring of places, strongest first: u, v and angle."""
    bend, angle = _bends(layer, sign, np.ascontiguousarray(u), np.ascontiguousarray(v))
    peaks = np.flatnonzero(bend > RIDGE_BEND_MIN_SIGMAS)
    around = peaks[:, None] + np.arange(-4, 5)
    peaks = peaks[bend[peaks] >= bend[around % len(bend)].max(axis=1)]
    peaks = peaks[np.argsort(-bend[peaks])][:ENTRIES_MAX]
    return np.stack([u[peaks], v[peaks], angle[peaks]], axis=1)


def followed(
    maps: MapArray, sign: float, u: float, v: float, angle: float, inset: float, gap_px: float
) -> tuple[FloatArray, BoolArray] | None:
    """Return (n, 2) the line at (u, v) in about this direction to where it is last seen.

    (n,) where it is.

    It begins `inset` before that place and may be hidden for `gap_px`. None when there is none of
    the least length.
    """
    rows, columns = maps.shape[2:]
    t = np.arange(0.0, math.hypot(rows, columns), STEP_PX)
    turn, score = _direction(
        maps, sign, u, v, angle, turns=TRIED_TURNS_RAD, back=inset, length=FIRST_LENGTH_PX
    )
    here = np.array([turn])
    _, begin = _direction(maps, sign, u, v, angle, turns=here, back=inset, length=BEGIN_LENGTH_PX)
    if score < LINE_SCORE_MIN or begin < LINE_BEGIN_SCORE_MIN:
        return None
    angle += turn
    u, v = u - inset * math.cos(angle), v - inset * math.sin(angle)
    first = round(FIRST_LENGTH_PX / STEP_PX)
    terms = np.stack([np.ones_like(t), t / t[-1], (t / t[-1]) ** 2], axis=1)
    line = np.zeros(3)  # its offset beside the straight line, a parabola
    far, done = first, False
    while not done:
        done = far == len(t)
        for _ in range(2):
            now = terms[:far] @ line
            offset, weight = _beside(maps, sign, *_on(u, v, angle, t[:far], now), angle)
            line = _parabola(terms[:far], now + offset, weight, line)
        far = min(len(t), 2 * far)
    place = _on(u, v, angle, t, terms @ line)
    _, weight = _beside(maps, sign, *place, angle)
    path = np.stack(place, axis=1)
    inside = (path >= 0).all(axis=1) & (path[:, 0] < columns) & (path[:, 1] < rows)
    mean = np.convolve(np.where(inside, weight, 0.0), np.ones(PIECE_STEPS) / PIECE_STEPS, "same")
    last = _last_seen(mean > LINE_SEEN_SCORE_MIN, gap_px)
    return (path[:last], mean[:last] > LINE_SEEN_SCORE_MIN) if last >= first else None


def _on(
    u: float, v: float, angle: float, t: FloatArray, beside: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return places at distances along a line, and beside it."""
    c, s = math.cos(angle), math.sin(angle)
    return u + c * t - s * beside, v + s * t + c * beside


@jit
def _direction(
    maps: MapArray,
    sign: float,
    u: float,
    v: float,
    angle: float,
    turns: FloatArray,
    back: float,
    length: float,
) -> tuple[float, float]:
    """Return the turn from `angle` under which it looks most like a ridge, and how much.

    From `back` before (u, v) on, for `length`.
    """
    best, most = 0.0, -1e9
    count = int(length / STEP_PX)
    for turn in turns:
        c, s = math.cos(angle + turn), math.sin(angle + turn)
        total = 0.0
        for q in range(count):
            place = (q + 0.5) * STEP_PX - back
            total += ridge_score(
                maps, sign, u + c * place, v + s * place, c, s, layers=1, half=BEND_AT_HALF_SCORE
            )
        if total > most:
            best, most = turn, total
    return best, most / count


@jit
def _beside(
    maps: MapArray, sign: float, u: FloatArray, v: FloatArray, angle: float
) -> tuple[FloatArray, FloatArray]:
    """Return where the ridge is beside each place, pixels to its left, and its score."""
    offset, weight = np.zeros(len(u)), np.zeros(len(u))
    c, s = math.cos(angle), math.sin(angle)
    score = np.empty(2 * CORRIDOR_PX + 1)
    for i in range(len(u)):
        most = -1.0
        for q in range(len(score)):
            d = q - CORRIDOR_PX
            score[q] = ridge_score(
                maps, sign, u[i] - s * d, v[i] + c * d, c, s, layers=1, half=BEND_AT_HALF_SCORE
            )
            most = max(most, score[q])
        if most < LINE_SCORE_MIN:
            continue
        total = 0.0
        for q in range(len(score)):
            if score[q] > 0.7 * most:
                total += score[q]
                offset[i] += score[q] * (q - CORRIDOR_PX)
        offset[i] /= total
        weight[i] = most
    return offset, weight


def _parabola(
    terms: FloatArray, offset: FloatArray, weight: FloatArray, line: FloatArray
) -> FloatArray:
    """Return the line through most of the offsets."""
    for _ in range(3):
        miss = (offset - terms @ line) / 2.5
        robust = weight * np.maximum(0.0, 1 - miss**2) ** 2
        normal = (terms * robust[:, None]).T @ terms + np.diag([1e-6, 1e-6, 1 / BOW_SIGMA_PX**2])
        line = np.linalg.solve(normal, terms.T @ (robust * offset))
    return np.asarray(line)


def _last_seen(seen: BoolArray, gap_px: float) -> int:
    """Return the number of steps up to the last one that is seen without too long a gap before."""
    at = np.flatnonzero(seen)
    if not len(at):
        return 0
    breaks = np.flatnonzero(np.diff(at) > gap_px / STEP_PX)
    return int(at[breaks[0]] if len(breaks) else at[-1]) + 1
