"""Gauss-Legendre collocation on one panel: nodes, weights, matrices, for each number of nodes.

A panel runs over theta in [0, 1]. Nodes are ascending.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from model.measurements import FloatArray


class Rule(NamedTuple):
    """The collocation rule with n nodes."""

    c: FloatArray  # (n,) nodes in (0, 1)
    b: FloatArray  # (n,) weights of the integral over the panel
    A: FloatArray  # (n, n) integrals of the Lagrange polynomials from 0 to each node
    A2: FloatArray  # (n, n) A @ A
    bA: FloatArray  # (n,) b @ A
    T: FloatArray  # (n, n) nodal values -> Legendre coefficients


@cache
def rule(nodes: int) -> Rule:
    """Return the rule with `nodes` nodes; exact to degree 2 n - 1 over the whole panel."""
    x, w = legendre.leggauss(nodes)
    degrees = np.arange(nodes)
    T = (degrees[:, None] + 0.5) * w[None, :] * legendre.legvander(x, nodes - 1).T
    A = 0.5 * integrated_legendre(x, nodes) @ T
    parts = [
        np.ascontiguousarray(part) for part in (0.5 * (x + 1.0), 0.5 * w, A, A @ A, 0.5 * w @ A, T)
    ]
    return Rule(*parts)


def integrated_legendre(t: FloatArray, count: int) -> FloatArray:
    """Return integrals of the first Legendre polynomials from -1 to t; shape (len(t), count)."""
    P = legendre.legvander(np.asarray(t), count)
    values = np.empty_like(P[:, :count])
    values[:, 0] = P[:, 1] + 1.0
    for k in range(1, count):
        values[:, k] = (P[:, k + 1] - P[:, k - 1]) / (2 * k + 1)
    return np.asarray(values)
