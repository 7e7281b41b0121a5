"""A curvature that is stated as a table, on as few elements as a smooth one needs.

The solver's time grows with the elements, and each place of a table would end one.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre

from model.measurements import FloatArray
from model.mechanics.collocation import rule
from model.mechanics.field import Field, padded

APART_M = 1e-9  # by which the sheet may lie elsewhere, so that forces keep six digits
BETWEEN = 8  # points of a piece of the table


def on_few_elements(
    field: Field, breaks_m: FloatArray, degree: int, apart_m: float = APART_M
) -> Field:
    """Return a field on `breaks_m`, each element divided where the sheet would lie elsewhere.

    On an element it is the polynomial of `degree` coefficients that is nearest (least squares), so
    the sheet turns as far, and ends where it would; in between it lies within `apart_m`.
    """
    todo = list(zip(breaks_m[:-1].tolist(), breaks_m[1:].tolist(), strict=True))[::-1]
    ends, rows = [float(breaks_m[0])], list[FloatArray]()
    while todo:
        low, high = todo.pop()
        inside = field.breaks_m[(field.breaks_m > low) & (field.breaks_m < high)]
        piece = np.concatenate([[low], inside, [high]])
        if not len(inside):
            rows.append(padded(field.on(piece).coefficients, degree)[0])
        else:
            near = _nearest(field, piece, degree)
            if _apart_m(field, Field(piece[[0, -1]], near[None]), piece) > apart_m:
                middle = float(inside[np.argmin(np.abs(inside - 0.5 * (low + high)))])
                todo += [(middle, high), (low, middle)]
                continue
            rows.append(near)
        ends.append(high)
    return Field(np.array(ends), np.stack(rows))


def _nearest(field: Field, piece_m: FloatArray, degree: int) -> FloatArray:
    """Return the nearest polynomial of a field between the ends of `piece_m`, as powers of t."""
    nodes = rule(degree)
    widths = np.diff(piece_m)[:, None]
    s = (piece_m[:-1, None] + widths * nodes.c).ravel()
    weights = (widths * nodes.b).ravel() * 2.0 / (piece_m[-1] - piece_m[0])
    t = (2.0 * s - piece_m[0] - piece_m[-1]) / (piece_m[-1] - piece_m[0])
    by_degree = legendre.legvander(t, degree - 1).T @ (weights * field(s))
    by_degree *= np.arange(degree) + 0.5
    return padded(np.asarray(legendre.leg2poly(by_degree)), degree)


def _apart_m(field: Field, other: Field, piece_m: FloatArray) -> float:
    """Return how far two sheets that begin alike lie apart, at most, between `piece_m`'s ends."""
    share = np.linspace(0.0, 1.0, BETWEEN, endpoint=False)
    s = (piece_m[:-1, None] + np.diff(piece_m)[:, None] * share).ravel()
    turn = (other.integral(s) - other.integral(s[0])) - (field.integral(s) - field.integral(s[0]))
    steps = 0.5 * (turn[1:] + turn[:-1]) * np.diff(s)
    return float(np.max(np.abs(np.cumsum(steps))))
