"""From a click to a point in the picture, to a fraction of a pixel.

Both ways weigh the picture's gradients g at pixels q around the click p. At a corner the edges run
through the point, so g is square to q - p: the point minimises the sum of (g . (q - p))^2. Around
something round g points to its middle: the point minimises the sum of (g x (q - p))^2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from labrig.errors import BadInputError

Point = tuple[float, float]
FloatArray = npt.NDArray[np.float64]
What = Literal["corner", "round"]

_ROUNDS = 20
_SETTLED_PX = 1e-3
_LEAST_CONTRAST = 6.0  # root mean square gradient over what noise alone makes
_LEAST_SPREAD = 0.02  # of the two directions' information: an edge alone fixes only one
_SIGMA_FLOOR_PX = 0.01


@dataclass(frozen=True)
class Refined:
    """Where it is, how well that is known, and how far from the click."""

    px: Point
    sigma_px: float
    moved_px: float


def refine(image: npt.NDArray[Any], click: Point, what: What, reach_px: float = 12.0) -> Refined:
    """Return the corner, or the middle of something round, near a click.

    Raises BadInputError when there is nothing sharp, or when it lies outside the reach.
    """
    point = np.array(click, dtype=float)
    if not all(math.isfinite(c) for c in click):
        raise BadInputError("the click is nowhere in the picture.")
    matrix = np.eye(2)
    variance = 0.0
    for _ in range(_ROUNDS):
        where, gradient = _gradients(image, point, reach_px)
        matrix, found, variance = _solve(where, gradient, point, what, reach_px)
        step = float(np.hypot(*(found - point)))
        point = found
        if float(np.hypot(*(point - click))) > reach_px:
            raise BadInputError(f"nothing {_NAMES[what]} lies within {reach_px:g} pixels.")
        if step < _SETTLED_PX:
            break
    sigma = math.sqrt(variance * float(np.trace(np.linalg.inv(matrix))) / 2 + _SIGMA_FLOOR_PX**2)
    moved = float(np.hypot(*(point - click)))
    return Refined((float(point[0]), float(point[1])), sigma, moved)


_NAMES = {"corner": "with a corner", "round": "round"}


def _gradients(
    image: npt.NDArray[Any], point: FloatArray, reach_px: float
) -> tuple[FloatArray, FloatArray]:
    """Pixels (n, 2) around a point and the gradients there, smoothed a little."""
    half = math.ceil(reach_px) + 3
    u, v = round(float(point[0])), round(float(point[1]))
    rows, columns = image.shape[:2]
    if not (half <= u < columns - half and half <= v < rows - half):
        raise BadInputError("that is too close to the picture's edge.")
    patch = image[v - half : v + half + 1, u - half : u + half + 1].astype(float)
    smooth = _smoothed(patch)
    down, right = np.gradient(smooth, axis=0), np.gradient(smooth, axis=1)
    inner = slice(3, -3)
    across = np.arange(-half, half + 1)[inner]
    grid_u, grid_v = np.meshgrid(across + u, across + v)
    where = np.stack([grid_u.ravel(), grid_v.ravel()], axis=1).astype(float)
    gradient = np.stack([right[inner, inner].ravel(), down[inner, inner].ravel()], axis=1)
    _check_contrast(patch, smooth, gradient)
    return where, gradient


def _smoothed(patch: FloatArray) -> FloatArray:
    """By the binomial of five, along both axes."""
    weights = np.array([1.0, 4.0, 6.0, 4.0, 1.0]) / 16
    padded = np.pad(patch, 2, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, (5, 5))
    return np.asarray(np.einsum("vuij,i,j->vu", windows, weights, weights))


def _check_contrast(patch: FloatArray, smooth: FloatArray, gradient: FloatArray) -> None:
    """Compare with the noise: what the smoothing removed, by its median."""
    rest = np.abs(patch - smooth)
    noise = max(1.4826 * float(np.median(rest)), 0.3)
    steep = np.sort(np.hypot(*gradient.T))[-max(8, len(gradient) // 50) :]
    if float(np.mean(steep)) < _LEAST_CONTRAST * noise / 4:
        raise BadInputError("nothing stands out of the picture there.")


def _solve(
    where: FloatArray, gradient: FloatArray, point: FloatArray, what: What, reach_px: float
) -> tuple[FloatArray, FloatArray, float]:
    """Information matrix, the new point, variance of what is left over."""
    away = where - point
    near = np.exp(-0.5 * (np.hypot(*away.T) / (0.5 * reach_px)) ** 2)
    g = gradient if what == "corner" else np.stack([-gradient[:, 1], gradient[:, 0]], axis=1)
    weighted = g * near[:, None]
    matrix = weighted.T @ g
    low, high = np.linalg.eigvalsh(matrix)
    if low < _LEAST_SPREAD * high:
        raise BadInputError(f"there is an edge, but nothing {_NAMES[what]}.")
    right = np.einsum("ni,nj,nj->i", weighted, g, away)
    found = point + np.linalg.solve(matrix, right)
    left = np.einsum("ni,ni->n", g, where - found)
    variance = float(np.sum(near * left**2) / max(np.sum(near), 1.0))
    return matrix, found, variance
