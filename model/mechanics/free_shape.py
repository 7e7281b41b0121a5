"""The sheet with nothing touching it: phi is the integral of the free curvature, so no solving."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from model.measurements import FloatArray
from model.mechanics.collocation import rule
from model.mechanics.field import Field

NODES = 6  # of each piece of the sheet


def free_shape(
    kappa: Field, s_m: FloatArray, directions: FloatArray | None = None
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """x, y, phi at s_m (ascending, from 0 on), and d(x, y)/d(direction) of shape (Q, S, 2).

    Directions are given by their `turns`. Beyond the free length the sheet goes on as a straight
    line.
    """
    s = np.asarray(s_m, dtype=float)
    edges, inside = _pieces(kappa, s)
    h, b, places = np.diff(edges), rule(NODES).b, np.searchsorted(edges, s)
    phi = kappa.integral(inside)

    def run(values: FloatArray) -> FloatArray:
        steps = np.cumsum(h * (values @ b), axis=-1)
        whole = np.concatenate([np.zeros((*steps.shape[:-1], 1)), steps], axis=-1)
        return np.asarray(whole[..., places])

    turn = np.zeros((0, *inside.shape)) if directions is None else directions
    answers = np.stack([run(-np.sin(phi) * turn), run(np.cos(phi) * turn)], axis=-1)
    return (
        run(np.cos(phi)),
        run(np.sin(phi)),
        kappa.integral(np.minimum(s, kappa.length_m)),
        answers,
    )


def turns(kappa: Field, s_m: FloatArray, fields: Sequence[Field]) -> FloatArray:
    """Return what curvatures turn a sheet by, where `free_shape` asks at these s: (Q, P, nodes)."""
    inside = _pieces(kappa, np.asarray(s_m, dtype=float))[1]
    return np.stack([field.integral(inside) for field in fields])


def _pieces(kappa: Field, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the ends of the pieces between panels and places, and the nodes in them."""
    edges = np.unique(np.concatenate([[0.0], kappa.breaks_m, s]))
    nodes = edges[:-1, None] + np.diff(edges)[:, None] * rule(NODES).c
    return edges, np.minimum(nodes, kappa.length_m)
