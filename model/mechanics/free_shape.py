"""The sheet with nothing touching it: phi is the integral of the free curvature, so no solving."""

from __future__ import annotations

import numpy as np

from model.measurements import FloatArray
from model.mechanics.collocation import rule
from model.mechanics.field import Field

NODES = 6  # of each piece of the sheet


def free_shape(kappa: Field, s_m: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, y and phi at s_m (ascending, from 0 on).

    Beyond the free length the sheet goes on as a straight line.
    """
    s = np.asarray(s_m, dtype=float)
    edges, inside = _pieces(kappa.breaks_m, s)
    phi, run = kappa.integral(inside), _PieceIntegrals(edges, s)
    return run(np.cos(phi)), run(np.sin(phi)), kappa.integral(np.minimum(s, kappa.length_m))


class SharedFreeShapes:
    """Free shapes of many curvatures on the same panels, at the same places.

    phi is linear in the curvature's coefficients, so that only this matrix is worked out once.
    """

    def __init__(self, breaks_m: FloatArray, degree: int, s_m: FloatArray) -> None:
        edges, inside = _pieces(breaks_m, s_m)
        self._shape = inside.shape
        self._inside = Field.integral_weights(breaks_m, degree, inside.ravel())
        end = np.minimum(s_m, breaks_m[-1])
        self._at_s = Field.integral_weights(breaks_m, degree, end)
        self._run = _PieceIntegrals(edges, s_m)
        self._turns: FloatArray | None = None

    def shape(self, kappa: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return x, y and phi of a curvature (panels, degree)."""
        phi = self._phi(kappa)
        return self._run(np.cos(phi)), self._run(np.sin(phi)), self._at_s @ kappa.ravel()

    def answers(self, kappa: FloatArray, directions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dx and dy (Q, S) by curvatures (Q, panels, degree), which are always the same."""
        phi = self._phi(kappa)
        if self._turns is None:
            turns = directions.reshape(len(directions), -1) @ self._inside.T
            self._turns = turns.reshape(len(directions), *self._shape)
        return self._run(-np.sin(phi) * self._turns), self._run(np.cos(phi) * self._turns)

    def _phi(self, kappa: FloatArray) -> FloatArray:
        phi: FloatArray = (self._inside @ kappa.ravel()).reshape(self._shape)
        return phi


class _PieceIntegrals:
    """Integrals of values at the nodes of pieces, up to each place."""

    def __init__(self, edges: FloatArray, s: FloatArray) -> None:
        self._h, self._b = np.diff(edges), rule(NODES).b
        self._places = np.searchsorted(edges, s)

    def __call__(self, values: FloatArray) -> FloatArray:
        steps = np.cumsum(self._h * (values @ self._b), axis=-1)
        whole = np.concatenate([np.zeros((*steps.shape[:-1], 1)), steps], axis=-1)
        return np.asarray(whole[..., self._places])


def _pieces(breaks_m: FloatArray, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the ends of the pieces between panels and places, and the nodes in them."""
    edges = np.unique(np.concatenate([[0.0], breaks_m, s]))
    nodes = edges[:-1, None] + np.diff(edges)[:, None] * rule(NODES).c
    return edges, np.minimum(nodes, breaks_m[-1])
