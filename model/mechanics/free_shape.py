"""The sheet with nothing touching it: phi is the integral of the free curvature, so no solving."""

from __future__ import annotations

import numpy as np

from model.measurements import FloatArray
from model.mechanics.collocation import rule
from model.mechanics.field import Field


def free_shape(
    kappa: Field, s_m: FloatArray, directions: list[Field] | None = None
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """x, y, phi at s_m (ascending, from 0 on), and d(x, y)/d(direction) of shape (Q, S, 2).

    Beyond the free length the sheet goes on as a straight line.
    """
    s = np.asarray(s_m, dtype=float)
    length, r = kappa.length_m, rule(6)
    edges = np.unique(np.concatenate([[0.0], kappa.breaks_m, s]))
    low, h = edges[:-1], np.diff(edges)
    nodes = low[:, None] + h[:, None] * r.c
    inside = np.minimum(nodes, length)
    phi = kappa.integral(inside)
    places = np.searchsorted(edges, s)

    def run(values: FloatArray) -> FloatArray:
        return np.concatenate([[0.0], np.cumsum(h * (values @ r.b))])[places]

    answers = np.zeros((len(directions or []), len(s), 2))
    for q, field in enumerate(directions or []):
        turn = field.integral(inside)
        answers[q, :, 0] = run(-np.sin(phi) * turn)
        answers[q, :, 1] = run(np.cos(phi) * turn)
    return run(np.cos(phi)), run(np.sin(phi)), kappa.integral(np.minimum(s, length)), answers
