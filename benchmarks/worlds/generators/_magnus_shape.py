"""Shapes of solved sheets at even places, from the clamp to the visible end."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from benchmarks.worlds.generators._magnus_motion import SIDE, THIRD, Path, path_of, turned
from benchmarks.worlds.generators._magnus_rod import (
    SEGMENTS,
    Cases,
    Sheets,
    State,
    beyond_contact,
    unheld,
)

Array = npt.NDArray[np.float64]
Shape = tuple[Array, Array, Array]  # x, y, direction at the places of each sheet, (n, places)
FREE_PASSES = 60  # of the weight's moments; each makes the rest about ten times smaller


def drawn(sheets: Sheets, cases: Cases, state: State, places: Array) -> Shape:
    """Return the shapes of held sheets."""
    n = len(cases.position_m)
    zero = np.zeros(n)
    mesh = np.full(n, sheets.rod.length_m) if sheets.bar else state.contact_m
    path = path_of(state.kappa, mesh[:, None] / SEGMENTS, zero, zero, state.root_rad)
    shape = _within(state.kappa, path, zero, places)
    if sheets.bar:
        return _on_the_bar(sheets, path, state.bent_rad, places, shape)
    kappa, tail = beyond_contact(sheets, cases, state, path)
    return _joined(shape, _within(kappa, tail, mesh, places), places > mesh[:, None])


def free(sheets: Sheets, cases: Cases, places: Array) -> Shape:
    """Return the shapes that nothing touches."""
    zero = np.zeros(len(cases.position_m))
    start = zero, zero, cases.root_rad
    whole = zero + sheets.rod.length_m
    kappa, path = unheld(sheets, cases, zero, whole, start, FREE_PASSES)
    shape = _within(kappa, path, zero, places)
    return _on_the_bar(sheets, path, zero, places, shape) if sheets.bar else shape


def _within(kappa: Array, path: Path, from_m: Array, places: Array) -> Shape:
    """Move on from the node before each place, by the part of its segment up to there."""
    h = np.maximum(path.h, 1e-12)
    count = kappa.shape[1]
    at = (places[None, :] - from_m[:, None]) / h
    e = np.clip(at.astype(int), 0, count - 1)
    t = at - e
    rows = np.arange(len(h))[:, None]
    k1, k2 = kappa[rows, e, 0], kappa[rows, e, 1]
    w = h * (0.5 * (k1 + k2) * t + 0.5 * THIRD * (k2 - k1) * (t * t - t))
    aside = h * h * t**3 * (k1 - k2) * SIDE[0]
    near = np.clip(w, -4.0, 4.0)  # places of another part may be far from any segment of this one
    (a,), (b,) = turned(near)
    u, v = a * h * t - b * aside, b * h * t + a * aside
    phi = path.phi[rows, e]
    c, s = np.cos(phi), np.sin(phi)
    return path.x[rows, e] + c * u - s * v, path.y[rows, e] + s * u + c * v, phi + w


def _on_the_bar(sheets: Sheets, path: Path, bent: Array, places: Array, shape: Shape) -> Shape:
    """Draw the elongation."""
    length, bow = sheets.rod.length_m, sheets.setting.bar_bow_per_m
    gone = np.maximum(places - length, 0.0)[None, :]
    (a,), (b,) = turned(bow * gone)
    phi = (path.phi[:, -1] + bent)[:, None]
    c, s = np.cos(phi), np.sin(phi)
    x = path.x[:, -1:] + gone * (c * a - s * b)
    y = path.y[:, -1:] + gone * (s * a + c * b)
    return _joined(shape, (x, y, phi + bow * gone), places[None, :] > length)


def _joined(near: Shape, far: Shape, beyond: npt.NDArray[np.bool_]) -> Shape:
    x, y, phi = (np.where(beyond, b, a) for a, b in zip(near, far, strict=True))
    return x, y, phi
