"""Motions of the plane: fourth-order Magnus maps of curvatures, and the weight along them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
THIRD = np.sqrt(3.0)
GAUSS = np.array([0.5 - THIRD / 6.0, 0.5 + THIRD / 6.0])
SIDE = np.array([1.0, -1.0]) * THIRD / 12.0  # of k1 and k2 in the motion aside
TERMS = 8


def _series() -> list[Array]:
    """Coefficients of sin(w)/w and (1 - cos(w))/w with two derivatives each."""
    a, b = np.zeros(2 * TERMS), np.zeros(2 * TERMS)
    below = 1.0
    for k in range(2 * TERMS):
        below *= k + 1.0  # (k + 1)!
        sign = (-1.0) ** (k // 2)
        (a if k % 2 == 0 else b)[k] = sign / below
    derived = np.polynomial.polynomial.polyder
    return [derived(c, m) for c in (a, b) for m in range(3)]


SERIES = _series()


def turned(w: Array, orders: int = 1) -> tuple[list[Array], list[Array]]:
    """Return sin(w)/w and (1 - cos(w))/w, and so many derivatives less one of each."""
    by = np.polynomial.polynomial.polyval
    return [by(w, SERIES[m]) for m in range(orders)], [by(w, SERIES[3 + m]) for m in range(orders)]


@dataclass
class Path:
    """Nodes of segments, (n, segments + 1)."""

    h: Array  # (n, 1), length of a segment
    x: Array
    y: Array
    phi: Array


def path_of(kappa: Array, h: Array, x: Array, y: Array, phi: Array) -> Path:
    """Follow segments from a place and direction (n,)."""
    w = 0.5 * h * (kappa[..., 0] + kappa[..., 1])
    aside = h * h * (kappa @ SIDE)
    (a,), (b,) = turned(w)
    u, v = a * h - b * aside, b * h + a * aside
    at = phi[:, None] + np.concatenate([0.0 * h, np.cumsum(w, axis=1)], axis=1)
    c, s = np.cos(at[:, :-1]), np.sin(at[:, :-1])
    gone = [np.cumsum(step, axis=1) for step in (c * u - s * v, s * u + c * v)]
    nodes = [
        p[:, None] + np.concatenate([0.0 * h, g], axis=1) for p, g in zip((x, y), gone, strict=True)
    ]
    return Path(h, nodes[0], nodes[1], at)


def hanging(path: Path, q: Array, last_N: Array, last_Nm: Array) -> tuple[Array, Array]:
    """Return the moment at nodes, and its slope, of the weight from there on.

    `last_N` hangs beyond the last node, with the moment `last_Nm` about it.
    """
    h, c = path.h, np.cos(path.phi)
    part = 0.5 * h * (path.x[:, 1:] + path.x[:, :-1]) + h * h / 12.0 * (c[:, :-1] - c[:, 1:])
    sums = np.cumsum(part[:, ::-1], axis=1)[:, ::-1]
    ahead = np.concatenate([sums, np.zeros_like(h)], axis=1)  # integral of x from a node on
    left = h * np.arange(path.x.shape[1])[::-1]
    q, last = q[:, None], last_N[:, None]
    moment = -q * (ahead - path.x * left) + last_Nm[:, None]
    moment = moment - last * (path.x[:, -1:] - path.x)
    return moment, c * (q * left + last)


def at_gauss(values: Array, slopes: Array, h: Array) -> Array:
    """Return values at the Gauss points of cubics with these ends, (n, segments, 2)."""
    t = GAUSS
    low, high = values[:, :-1, None], values[:, 1:, None]
    up, down = (h * slopes[:, :-1])[..., None], (h * slopes[:, 1:])[..., None]
    rise = 3 * t**2 - 2 * t**3
    return np.asarray(low + rise * (high - low) + (t - 2 * t**2 + t**3) * up + (t**3 - t**2) * down)
