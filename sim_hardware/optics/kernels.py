"""The inner loops of the renderer, compiled. Import this where it is used: numba is slow to load.

Pictures are flat float32 arrays of rows * columns. `touched` lists the pixels of a layer that
differ from the empty one, so that only those need to be visited and put back.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

import numba
import numpy as np
import numpy.typing as npt

_P = ParamSpec("_P")
_R = TypeVar("_R")

Floats = npt.NDArray[np.float64]
Picture = npt.NDArray[np.float32]


def _compiled(function: Callable[_P, _R]) -> Callable[_P, _R]:
    return cast("Callable[_P, _R]", numba.njit(cache=True, nogil=True)(function))


@_compiled
def edge(depth: float, softness: float) -> float:
    """Light of a pixel whose centre lies this deep inside a straight edge, both in px."""
    return 0.5 * (1.0 + math.erf(depth / (math.sqrt(2.0) * softness)))


@_compiled
def draw_band(
    points: Floats,
    half_width: Floats,
    level: Floats,
    softness: float,
    layer: Picture,
    columns: int,
    touched: npt.NDArray[np.int32],
    count: int,
) -> int:
    """Draw the band along a polyline (n, 2) in pixels, cut off square at both ends.

    `layer` (pixels, 5) holds of the piece of polyline nearest to each pixel: squared distance
    (infinite: none is near), signed distance, half width, grey level, and how deep the pixel lies
    inside the band's nearest end. Bands drawn into the same layer unite. Returns how many pixels
    are touched so far.
    """
    rows = layer.shape[0] // columns
    last = points.shape[0] - 1
    margin = 4.0 * softness
    total = 0.0
    for k in range(last):
        total += math.hypot(points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1])
    passed = 0.0
    for k in range(last):
        x0 = points[k, 0]
        y0 = points[k, 1]
        length = math.hypot(points[k + 1, 0] - x0, points[k + 1, 1] - y0)
        if length == 0.0:
            continue
        tx = (points[k + 1, 0] - x0) / length
        ty = (points[k + 1, 1] - y0) / length
        reach = max(half_width[k], half_width[k + 1]) + margin
        left = max(0, math.floor(min(x0, points[k + 1, 0]) - reach))
        right = min(columns - 1, math.ceil(max(x0, points[k + 1, 0]) + reach))
        top = max(0, math.floor(min(y0, points[k + 1, 1]) - reach))
        bottom = min(rows - 1, math.ceil(max(y0, points[k + 1, 1]) + reach))
        # Past its ends the band goes on for a little, for the square cut to be made in it.
        before_allowed = margin if k == 0 else 0.0
        past_allowed = margin if k == last - 1 else 0.0
        for row in range(top, bottom + 1):
            for column in range(left, right + 1):
                along = (column - x0) * tx + (row - y0) * ty
                across = (row - y0) * tx - (column - x0) * ty
                over = max(0.0, -along - before_allowed, along - length - past_allowed)
                distance2 = across * across + over * over
                pixel = row * columns + column
                if distance2 > reach * reach or distance2 >= layer[pixel, 0]:
                    continue
                if layer[pixel, 0] == np.inf:
                    touched[count] = pixel
                    count += 1
                part = min(1.0, max(0.0, along / length))
                layer[pixel, 0] = distance2
                layer[pixel, 1] = across
                layer[pixel, 2] = half_width[k] + part * (half_width[k + 1] - half_width[k])
                layer[pixel, 3] = level[k] + part * (level[k + 1] - level[k])
                layer[pixel, 4] = min(passed + along, total - passed - along)
        passed += length
    return count


@_compiled
def lay_down(
    layer: Picture,
    touched: npt.NDArray[np.int32],
    count: int,
    softness: float,
    share: float,
    hidden: Picture,
    light: Picture,
) -> None:
    """Add `share` of a layer to what hides the background and to the light; clear the layer."""
    for k in range(count):
        pixel = touched[k]
        across = layer[pixel, 1]
        half = layer[pixel, 2]
        inside = edge(half - across, softness) - edge(-half - across, softness)
        part = share * inside
        if layer[pixel, 4] < 4.0 * softness:
            part *= edge(layer[pixel, 4], softness)
        hidden[pixel] += part
        light[pixel] += part * layer[pixel, 3]
        layer[pixel, 0] = np.inf


@_compiled
def draw_disc(
    picture: Picture,
    columns: int,
    u: float,
    v: float,
    radius: float,
    level: float,
    rim: float,
    rim_level: float,
) -> None:
    """Draw a disc with a rim of another level over the picture."""
    rows = picture.size // columns
    for row in range(max(0, math.floor(v - radius - 1)), min(rows, math.ceil(v + radius + 2))):
        for column in range(
            max(0, math.floor(u - radius - 1)), min(columns, math.ceil(u + radius + 2))
        ):
            distance = math.hypot(column - u, row - v)
            outside = min(1.0, max(0.0, distance - radius + 0.5))
            inside = min(1.0, max(0.0, radius - rim - distance + 0.5))
            disc = inside * level + (1.0 - inside) * rim_level
            pixel = row * columns + column
            picture[pixel] += (1.0 - outside) * (disc - picture[pixel])


@_compiled
def mixed(key: np.uint64) -> np.uint64:
    """A 64-bit hash (the finaliser of splitmix64), to turn counters into random bits."""
    z = (key ^ (key >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@_compiled
def expose(
    picture: Picture,
    gain: Picture,
    glare: Picture,
    seed: int,
    number: int,
    shot_variance_per_level: float,
    read_variance: float,
    out: npt.NDArray[np.uint8],
) -> None:
    """What the sensor makes of the light: uneven light, reflections, noise, whole grey levels.

    The noise of a pixel depends on the seed, the frame number and the pixel only. It is the sum of
    eight random bytes, Gaussian to within 0.15 in kurtosis, and ends at 4.9 standard deviations.
    """
    golden = np.uint64(0x9E3779B97F4A7C15)
    key = mixed(np.uint64(seed) * golden + np.uint64(1)) ^ mixed(np.uint64(number) + golden)
    bytes_even = np.uint64(0x00FF00FF00FF00FF)
    scale = np.float32(1.0 / math.sqrt(8.0 * (256.0**2 - 1.0) / 12.0))
    shot = np.float32(shot_variance_per_level)
    read = np.float32(read_variance)
    for pixel in range(picture.size):
        bits = mixed(key + np.uint64(pixel) * golden)
        pairs = (bits & bytes_even) + ((bits >> np.uint64(8)) & bytes_even)
        total = (pairs * np.uint64(0x0001000100010001)) >> np.uint64(48)
        value = picture[pixel] * gain[pixel] + glare[pixel]
        deviation = math.sqrt(max(value, np.float32(0.0)) * shot + read)
        value += (np.float32(np.int32(total)) - np.float32(1020.0)) * scale * deviation
        out[pixel] = np.uint8(min(max(value + np.float32(0.5), np.float32(0.0)), np.float32(255.0)))
