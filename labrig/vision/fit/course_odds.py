"""The log odds of each block of a course that the strip is there, compiled: blocks come in turn.

What a block is compared with is what the strip and its ground looked like shortly before.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from labrig.vision.jit import jit
from labrig.vision.thresholds import (
    COURSE_ALIKE_MIN,
    COURSE_EDGE_RATIO,
    COURSE_PROFILE_SIGMA_MIN,
    COURSE_STRIP_SPREAD,
    COURSE_WIDE_RATIO,
)

FloatArray = npt.NDArray[np.float64]

EDGE_SPREAD = 0.4  # of the logarithm of an edge's size
SAID_MAX = 2.0  # by one block
SAID_UNLIKE = -0.1  # by edges of what does not look like the strip shortly before
OWN_SHARE_MIN = 0.4  # of a profile that is no noise, at least
ADAPT_MIN = 0.5  # log odds of a block that is remembered
ALL, PROFILE, EDGES, SHIFT, UNLIKE = 0, 1, 2, 3, 4  # rows of what is told


@jit
def _agreement(size: FloatArray, usual: FloatArray, at: int) -> float:
    """Return the product of a block's profile (channels, across) from `at` on with another one."""
    total = 0.0
    for channel in range(usual.shape[0]):
        for k in range(usual.shape[1]):
            total += size[channel, at + k] * usual[channel, k]
    return total


@jit
def _largest(size: FloatArray, usual: FloatArray, first: int, end: int) -> tuple[int, float]:
    """Return where from `first` to before `end` a profile agrees most with another, and how much.

    The first one of equal ones.
    """
    best, most = first, -1e300
    for at in range(first, end):
        each = _agreement(size, usual, at)
        if each > most:
            best, most = at, each
    return best, most


@jit
def _remember(ordered: FloatArray, latest: FloatArray, many: int, value: float) -> None:
    """Put a number in its place among the latest ones; the oldest goes if these are full."""
    keep = len(latest)
    count = min(many, keep)
    slot = many % keep
    if many >= keep:
        at = 0
        while at < count and ordered[at] != latest[slot]:  # NaN equals nothing
            at += 1
        count -= 1
        while at < count:
            ordered[at] = ordered[at + 1]
            at += 1
    latest[slot] = value
    at = count
    while at > 0 and ordered[at - 1] > value:
        ordered[at] = ordered[at - 1]
        at -= 1
    ordered[at] = value


@jit
def _middle_and_scatter(ordered: FloatArray, many: int) -> tuple[float, float]:
    """Return the median of the first ordered numbers, and their median distance from it."""
    half = many // 2
    middle = ordered[half] if many % 2 else 0.5 * (ordered[half - 1] + ordered[half])
    low, high = half - 1, half  # the nearest ones that are left on both sides
    before, last = 0.0, 0.0
    for _ in range(half + 1):
        left = middle - ordered[low] if low >= 0 else 1e300
        right = ordered[high] - middle if high < many else 1e300
        before = last
        if left < right:
            last = left
            low -= 1
        else:
            last = right
            high += 1
    return middle, last if many % 2 else 0.5 * (before + last)


@jit
def _of_profile(strength: float, alike: float, usual: float, scatter: float) -> float:
    """Return the log odds of a profile's size against what the same search finds beside."""
    spread = max(1.48 * scatter, COURSE_PROFILE_SIGMA_MIN)
    strip = max(COURSE_STRIP_SPREAD, spread)
    odds = math.log(spread / strip) - 0.5 * ((min(strength, 1.0) - 1) / strip) ** 2
    odds += 0.5 * (max(strength - usual, 0.0) / spread) ** 2
    if alike < COURSE_ALIKE_MIN:
        odds = min(odds, 0.0) - 0.3
    return min(max(odds, -SAID_MAX), SAID_MAX)


@jit
def _of_edges(edge: float, usual: float, ground: float) -> float:
    """Return the log odds of how clear both edges are against what is found beside."""
    apart = math.log(max(usual, 1e-6) / ground)
    if apart <= 0:
        return -0.5
    least = max(math.sqrt(usual * ground), COURSE_EDGE_RATIO * usual)
    odds = math.log(max(min(edge, usual), 1e-6) / least) * apart / EDGE_SPREAD**2
    return min(max(odds, -SAID_MAX), SAID_MAX)


@jit
def log_odds(
    size: FloatArray,
    usual: FloatArray,
    edges: FloatArray,
    usual_edge: float,
    ground: FloatArray,
    wider: FloatArray,
    few: int,
    far: int,
    memory: float,
    near: int,
) -> FloatArray:
    """Return (5, blocks) log odds of all, of profile, of edges, the profile's shift, unlike.

    `size` (blocks, channels, across): see `course`; `usual` (channels, across) the strip's first
    profile, which is changed. `few`, `far`: by how many places the strip may lie aside, and from
    where on is the ground. `memory`, `near`: blocks of strip and ground that are remembered.
    """
    count, wide = size.shape[0], usual.shape[1]
    last = size.shape[2] - wide
    middle = (last + 1) // 2
    told = np.zeros((5, count))
    beside, noise = np.empty(near), np.empty(near)  # what looks like the strip there, and changes
    latest_beside, latest_noise = np.empty(near), np.empty(near)
    for b in range(count):
        one = size[b]
        usual_size = _agreement(usual, usual, 0)
        at, agreed = _largest(one, usual, middle - few, middle + few + 1)
        _, left = _largest(one, usual, 0, middle - far + 1)
        _, right = _largest(one, usual, middle + far, last + 1)
        found = one[:, at : at + wide]
        begin, end = one[:, :wide], one[:, last:]
        _remember(noise, latest_noise, 2 * b, _agreement(begin, begin, 0))
        _remember(noise, latest_noise, 2 * b + 1, _agreement(end, end, 0))
        scale = 1 / max(usual_size, 1e-12)
        _remember(beside, latest_beside, 2 * b, left * scale)
        _remember(beside, latest_beside, 2 * b + 1, right * scale)
        many = min(2 * b + 2, near)
        own = _agreement(found, found, 0)
        own = max(own - _middle_and_scatter(noise, many)[0], OWN_SHARE_MIN * own)
        alike = agreed / math.sqrt(own * usual_size + 1e-12)
        ground_usual, scatter = _middle_and_scatter(beside, many)
        by_profile = _of_profile(agreed * scale, alike, ground_usual, scatter)
        by_edges = _of_edges(edges[b], usual_edge, ground[b])
        said = max(by_profile, by_edges)
        if alike < COURSE_ALIKE_MIN:
            another = wider[b] > COURSE_WIDE_RATIO * edges[b]
            told[UNLIKE, b] = another or by_edges > 0
            by_edges = -SAID_MAX if another else min(by_edges, SAID_UNLIKE)
            said = by_edges if another else max(by_profile, by_edges)
        told[ALL, b], told[PROFILE, b], told[EDGES, b] = said, by_profile, by_edges
        told[SHIFT, b] = at - middle
        if said > ADAPT_MIN:
            share = 1 / (1 + math.exp(-said)) / memory
            for channel in range(usual.shape[0]):
                for k in range(wide):
                    usual[channel, k] += share * (found[channel, k] - usual[channel, k])
            usual_edge *= (edges[b] / usual_edge) ** share
    return told
