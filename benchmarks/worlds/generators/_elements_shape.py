"""Shapes of solved sheets at even places, from the clamp to the visible end."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from benchmarks.worlds.generators._elements_beam import (
    ELEMENTS,
    NODES,
    Beam,
    Cases,
    Found,
    tail,
)

Array = npt.NDArray[np.float64]
TAIL = 33  # directions beyond the contact


def drawn(beam: Beam, cases: Cases, found: Found, places: Array) -> tuple[Array, Array, Array]:
    """Return x, y and direction at the places of each sheet: (n, places)."""
    n = len(cases.position_m)
    mesh = np.full(n, beam.blade.length_m) if beam.bar else found.contact_m
    phi = found.phi @ _finer().T
    s, x, y, at = _path(np.zeros((n, 2)), np.zeros(n), mesh, phi)
    if beam.bar:
        left, beyond = np.full(n, beam.blade.elongation_m), np.tile(found.angle_rad, (TAIL, 1)).T
    else:
        left, beyond = tail(beam, cases, found, TAIL)
    more = _path(np.stack([x[:, -1], y[:, -1]], axis=1), mesh, left, beyond)
    joined = [np.concatenate(pair, axis=1) for pair in zip((s, x, y, at), more, strict=True)]
    return _even(joined, places)


def _finer() -> Array:
    """Return what makes of nodal directions those at quarters of the elements."""
    t = np.linspace(0.0, 1.0, 4 * ELEMENTS + 1)
    e = np.minimum((t * ELEMENTS).astype(int), ELEMENTS - 1)
    u = t * ELEMENTS - e
    by = np.zeros((len(t), NODES))
    rows = np.arange(len(t))
    by[rows, 2 * e] = (1 - u) * (1 - 2 * u)
    by[rows, 2 * e + 1] = 4 * u * (1 - u)
    by[rows, 2 * e + 2] = u * (2 * u - 1)
    return by


def _path(
    start: Array, from_m: Array, length: Array, phi: Array
) -> tuple[Array, Array, Array, Array]:
    """Integrate even directions by Simpson's rule: s, x, y, phi at every second one."""
    count = (phi.shape[1] - 1) // 2
    s = from_m[:, None] + length[:, None] * np.linspace(0.0, 1.0, count + 1)
    result = [s]
    for k, part in enumerate((np.cos(phi), np.sin(phi))):
        steps = (part[:, :-2:2] + 4.0 * part[:, 1::2] + part[:, 2::2]) / 6.0
        steps = np.cumsum(steps * length[:, None] / count, axis=1)
        result.append(start[:, k : k + 1] + np.concatenate([0.0 * steps[:, :1], steps], axis=1))
    return result[0], result[1], result[2], phi[:, ::2]


def _even(path: list[Array], places: Array) -> tuple[Array, Array, Array]:
    """Interpolate with the slopes that the directions are."""
    s, x, y, phi = path
    n, last = s.shape
    at = np.stack([np.searchsorted(row, places, side="right") - 1 for row in s])
    at = np.clip(at, 0, last - 2)

    def ends(values: Array) -> tuple[Array, Array]:
        rows = np.arange(n)[:, None]
        return values[rows, at], values[rows, at + 1]

    (a, b), (p, q) = ends(s), ends(phi)
    h = np.where(b > a, b - a, 1.0)
    t = (places - a) / h
    shown = []
    for values, slope in ((x, np.cos), (y, np.sin)):
        u, v = ends(values)
        du, dv = h * slope(p), h * slope(q)
        cubic = u + t * (du + t * (3 * (v - u) - 2 * du - dv + t * (2 * (u - v) + du + dv)))
        shown.append(cubic)
    return shown[0], shown[1], p + t * (q - p)
