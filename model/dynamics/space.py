"""The sheet's curvature as Legendre polynomials in panels, with the nodes at which forces act.

k(s, t) = sum_j q_j P_j in each panel; k may jump between panels, phi and r cannot: they are
integrals of k, so the sheet does not stretch. A panel without polynomials is rigid: the elongation,
and, with no width, a mass at its end. A panel of d polynomials has d + 5 Gauss-Legendre nodes.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from model.measurements import FloatArray
from model.mechanics.collocation import integrated_legendre, rule

MORE_NODES = 5  # than polynomials: products of sines and polynomials are integrated
RIGID_NODES = 3  # exact for the inertia of a rigid panel


class Space(NamedTuple):
    """Panels p, nodes m and coefficients j; a panel's nodes and coefficients are contiguous."""

    breaks_m: FloatArray  # (P + 1,) ends of the panels
    flexible: int  # panels that bend; rigid ones follow
    first_node: np.ndarray[tuple[int], np.dtype[np.int64]]  # (P + 1,)
    first_dof: np.ndarray[tuple[int], np.dtype[np.int64]]  # (P + 1,)
    s_m: FloatArray  # (M,) nodes
    weight_m: FloatArray  # (M,) of the integral over s
    turn: FloatArray  # (M, D) integrals of P_j from the panel's start to a node
    run: FloatArray  # (M, n) nodal values of the panel -> their integral from its start to a node
    to_legendre: FloatArray  # (M, n) row d of a panel: nodal values -> coefficient of P_d
    value: FloatArray  # (M, D) P_j at the nodes

    @property
    def size(self) -> int:
        """Return the number of coefficients."""
        return int(self.first_dof[-1])

    @property
    def length_m(self) -> float:
        """Return the length that bends."""
        return float(self.breaks_m[self.flexible])


def space(breaks_m: Sequence[float], degrees: Sequence[int], elongation_m: float = 0.0) -> Space:
    """Return panels between `breaks_m` with `degrees` polynomials each, then the rigid end.

    The rigid end is the elongation's panel and one of no width, in which a mass may be put.
    """
    end = breaks_m[-1] + elongation_m
    edges = np.array([*breaks_m, end, end])
    counts = [*degrees, 0, 0]
    nodes = [*(d + MORE_NODES for d in degrees), RIGID_NODES, 1]
    rows, most, widest = sum(nodes), max(counts), max(nodes)
    first_node = np.concatenate([[0], np.cumsum(nodes)])
    turn, value = np.zeros((rows, most)), np.zeros((rows, most))
    run, to_legendre = np.zeros((rows, widest)), np.zeros((rows, widest))
    s, weight = np.zeros(rows), np.zeros(rows)
    for p, (low, high) in enumerate(pairwise(edges)):
        n, d, h, r = nodes[p], counts[p], high - low, rule(nodes[p])
        here = slice(first_node[p], first_node[p + 1])
        s[here], weight[here] = low + h * r.c, h * r.b
        run[here, :n], to_legendre[here, :n] = h * r.A, r.T
        values, integrals = _polynomials(n, d)
        value[here, :d], turn[here, :d] = values, 0.5 * h * integrals
    return Space(
        breaks_m=edges, flexible=len(degrees), first_node=first_node,
        first_dof=np.concatenate([[0], np.cumsum(counts)]), s_m=s, weight_m=weight,
        turn=turn, run=run, to_legendre=to_legendre, value=value,
    )  # fmt: skip


@cache
def _polynomials(nodes: int, count: int) -> tuple[FloatArray, FloatArray]:
    """Return P_j at the nodes of a panel and their integrals from -1, (nodes, count) each."""
    t = 2.0 * rule(nodes).c - 1.0
    if count == 0:
        return np.zeros((nodes, 0)), np.zeros((nodes, 0))
    return np.asarray(legendre.legvander(t, count - 1)), integrated_legendre(t, count)


class Panels:
    """A space as a key: the same panels have the same matrices, which many runs share."""

    __slots__ = ("_key", "on")

    def __init__(self, on: Space) -> None:
        self.on, self._key = on, (on.breaks_m.tobytes(), on.first_dof.tobytes())

    def __hash__(self) -> int:
        return hash(self._key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Panels) and self._key == other._key


def norms(on: Space) -> FloatArray:
    """Return int P_j^2 ds of each coefficient, (N,)."""
    widths = np.diff(on.breaks_m)
    return np.concatenate([
        widths[p] / (2.0 * np.arange(on.first_dof[p + 1] - on.first_dof[p]) + 1.0)
        for p in range(on.flexible)
    ])  # fmt: skip


def moments(on: Space) -> FloatArray:
    """Return the matrix (N, M) that takes nodal values to int f P_j ds; not to be changed."""
    return _moments(Panels(on))


@lru_cache(maxsize=16)
def _moments(panels: Panels) -> FloatArray:
    on = panels.on
    rows = np.zeros((on.size, len(on.s_m)))
    for p in range(on.flexible):
        nodes = slice(on.first_node[p], on.first_node[p + 1])
        dofs = slice(on.first_dof[p], on.first_dof[p + 1])
        rows[dofs, nodes] = (on.value[nodes, : dofs.stop - dofs.start] * on.weight_m[nodes, None]).T
    return rows


class Rows(NamedTuple):
    """Matrices that take coefficients and nodal values to S points along the sheet."""

    curvature: FloatArray  # (S, N)
    angle: FloatArray  # (S, N) integral of k from the clamp
    position: FloatArray  # (S, M) integral of nodal values from the clamp


def rows_at(on: Space, s_m: FloatArray) -> Rows:
    """Return the matrices for points from the clamp to the end of the elongation; not to change."""
    return _rows_at(Panels(on), tuple(np.atleast_1d(np.asarray(s_m, dtype=float)).tolist()))


@lru_cache(maxsize=64)
def _rows_at(panels: Panels, places_m: tuple[float, ...]) -> Rows:
    on, s = panels.on, np.array(places_m)
    panel = np.clip(np.searchsorted(on.breaks_m[1:-1], s, side="left"), 0, len(on.breaks_m) - 3)
    k, angle = np.zeros((len(s), on.size)), np.zeros((len(s), on.size))
    position = np.zeros((len(s), len(on.s_m)))
    for p in range(len(on.breaks_m) - 2):
        nodes = slice(on.first_node[p], on.first_node[p + 1])
        first, count = on.first_dof[p], int(on.first_dof[p + 1] - on.first_dof[p])
        h, n = on.breaks_m[p + 1] - on.breaks_m[p], nodes.stop - nodes.start
        beyond, here = panel > p, panel == p
        if count:
            angle[beyond, first] = h
        position[np.ix_(beyond, np.arange(nodes.start, nodes.stop))] = on.weight_m[nodes]
        if h <= 0.0 or not here.any():
            continue
        t = 2.0 * (s[here] - on.breaks_m[p]) / h - 1.0
        integrals = 0.5 * h * integrated_legendre(t, n)
        position[np.ix_(here, np.arange(nodes.start, nodes.stop))] = (
            integrals @ on.to_legendre[nodes, :n]
        )
        if count:
            dofs = np.arange(first, first + count)
            angle[np.ix_(here, dofs)] = integrals[:, :count]
            k[np.ix_(here, dofs)] = legendre.legvander(t, count - 1)
    return Rows(k, angle, position)


def dense(on: Space) -> tuple[FloatArray, FloatArray]:
    """Return angle (M, N) and position (M, M) at all nodes as whole matrices; not to be changed."""
    return _dense(Panels(on))


@lru_cache(maxsize=16)
def _dense(panels: Panels) -> tuple[FloatArray, FloatArray]:
    on = panels.on
    M = len(on.s_m)
    angle, position = np.zeros((M, on.size)), np.zeros((M, M))
    for p, (low, high) in enumerate(pairwise(on.breaks_m)):
        nodes = slice(on.first_node[p], on.first_node[p + 1])
        dofs = slice(on.first_dof[p], on.first_dof[p + 1])
        angle[nodes, dofs] = on.turn[nodes, : dofs.stop - dofs.start]
        position[nodes, nodes] = on.run[nodes, : nodes.stop - nodes.start]
        if dofs.stop > dofs.start:
            angle[nodes.stop :, dofs.start] = high - low
        position[nodes.stop :, nodes] = on.weight_m[nodes]
    return angle, position


def operators(on: Space, nodes: int, M: int, P: int) -> dict[str, FloatArray]:
    """Return the matrices of the first nodes, filled up to M nodes and P coefficients with 0.

    They are `turn` (N, M), `angle` (M, P), `run` (M, M), its transpose `back`, `weight_m` (M,) and
    `to_legendre` (M, n); not to be changed.
    """
    return _operators(Panels(on), nodes, M, P)


@lru_cache(maxsize=16)
def _operators(panels: Panels, nodes: int, M: int, P: int) -> dict[str, FloatArray]:
    on = panels.on
    angle, position = _dense(panels)
    wide, square = np.zeros((M, P)), np.zeros((M, M))
    wide[:nodes, : on.size] = angle[:nodes]
    square[:nodes, :nodes] = position[:nodes, :nodes]
    weight, rows = np.zeros(M), np.zeros((M, on.to_legendre.shape[1]))
    weight[:nodes], rows[:nodes] = on.weight_m[:nodes], on.to_legendre[:nodes]
    return {
        "turn": np.ascontiguousarray(wide[:, : on.size].T), "angle": wide,
        "run": np.ascontiguousarray(square.T), "back": square, "weight_m": weight,
        "to_legendre": rows,
    }  # fmt: skip
