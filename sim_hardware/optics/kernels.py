"""The inner loops of the renderer, compiled. Import this where it is used: numba is slow to load.

Images are flat float32 arrays of rows * columns. `touched` lists the pixels of a layer that
differ from the empty one, so that only those need to be visited and put back.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from sim_hardware.jit import strict_jit

Floats = npt.NDArray[np.float64]
Image = npt.NDArray[np.float32]


class PixelBand(NamedTuple):
    """A band along a polyline, at each of its points."""

    points: Floats  # (n, 2), in pixels
    half_width: Floats  # in pixels
    level: Floats  # grey level


class Layer(NamedTuple):
    """A layer on which bands are drawn, and its pixels that they touch."""

    pixels: Image  # (pixels, 5), see `draw_band`
    columns: int
    touched: npt.NDArray[np.int32]
    softness: float  # of the edges, in pixels


class Disc(NamedTuple):
    """A disc with a rim of another level; lengths in pixels."""

    u: float
    v: float
    radius: float
    level: float
    rim: float
    rim_level: float


class Sensor(NamedTuple):
    """The noise of one frame."""

    seed: int
    number: int
    shot_variance_per_level: float
    read_variance: float


@strict_jit
def edge(depth: float, softness: float) -> float:
    """Light of a pixel whose centre lies this deep inside a straight edge, both in px."""
    return 0.5 * (1.0 + math.erf(depth / (math.sqrt(2.0) * softness)))


@strict_jit
def draw_band(band: PixelBand, into: Layer, count: int) -> int:
    """Draw a band, cut off square at both ends; `count` pixels are touched already.

    The layer's pixels hold of the piece of polyline nearest to each: squared distance (infinite:
    none is near), signed distance, half width, grey level, and how deep the pixel lies inside the
    band's nearest end. Bands drawn into the same layer unite. Returns how many pixels are touched
    so far.
    """
    points, half_width, level = band.points, band.half_width, band.level
    layer, columns, touched, softness = into.pixels, into.columns, into.touched, into.softness
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


@strict_jit
def lay_down(drawn: Layer, count: int, share: float, hidden: Image, light: Image) -> None:
    """Add `share` of a layer to what hides the background and to the light; clear the layer."""
    layer, touched, softness = drawn.pixels, drawn.touched, drawn.softness
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


@strict_jit
def draw_disc(image: Image, columns: int, disc: Disc) -> None:
    """Draw a disc over the image."""
    u, v, radius = disc.u, disc.v, disc.radius
    level, rim, rim_level = disc.level, disc.rim, disc.rim_level
    rows = image.size // columns
    for row in range(max(0, math.floor(v - radius - 1)), min(rows, math.ceil(v + radius + 2))):
        for column in range(
            max(0, math.floor(u - radius - 1)), min(columns, math.ceil(u + radius + 2))
        ):
            distance = math.hypot(column - u, row - v)
            outside = min(1.0, max(0.0, distance - radius + 0.5))
            inside = min(1.0, max(0.0, radius - rim - distance + 0.5))
            light = inside * level + (1.0 - inside) * rim_level
            pixel = row * columns + column
            image[pixel] += (1.0 - outside) * (light - image[pixel])


@strict_jit
def mixed(key: np.uint64) -> np.uint64:
    """Hash 64 bits (the finaliser of splitmix64), to turn counters into random bits."""
    z = (key ^ (key >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@strict_jit
def expose(
    image: Image,
    gain: Image,
    glare: Image,
    sensor: Sensor,
    out: npt.NDArray[np.uint8],
) -> None:
    """Fill `out` with the sensor's grey levels: uneven light, reflections, noise, rounding.

    The noise of a pixel depends on the seed, the frame number and the pixel only. It is the sum of
    eight random bytes, Gaussian to within 0.15 in kurtosis, and ends at 4.9 standard deviations.
    """
    golden = np.uint64(0x9E3779B97F4A7C15)
    frame = mixed(np.uint64(sensor.number) + golden)
    key = mixed(np.uint64(sensor.seed) * golden + np.uint64(1)) ^ frame
    bytes_even = np.uint64(0x00FF00FF00FF00FF)
    scale = np.float32(1.0 / math.sqrt(8.0 * (256.0**2 - 1.0) / 12.0))
    shot = np.float32(sensor.shot_variance_per_level)
    read = np.float32(sensor.read_variance)
    for pixel in range(image.size):
        bits = mixed(key + np.uint64(pixel) * golden)
        pairs = (bits & bytes_even) + ((bits >> np.uint64(8)) & bytes_even)
        total = (pairs * np.uint64(0x0001000100010001)) >> np.uint64(48)
        value = image[pixel] * gain[pixel] + glare[pixel]
        deviation = math.sqrt(max(value, np.float32(0.0)) * shot + read)
        value += (np.float32(np.int32(total)) - np.float32(1020.0)) * scale * deviation
        out[pixel] = np.uint8(min(max(value + np.float32(0.5), np.float32(0.0)), np.float32(255.0)))
