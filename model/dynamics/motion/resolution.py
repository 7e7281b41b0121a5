"""Steps and polynomials of a simulation, and where its steps end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from model.measurements import FloatArray, ModelError

SAME_TIME = 1e-9  # s: instants nearer than this are one
AFTER_EDGE_S = 0.1  # so long a voltage edge excites modes above the first
Counts = np.ndarray[Any, np.dtype[np.int64]]


@dataclass(frozen=True, kw_only=True)
class Resolution:
    """Steps and polynomials of a simulation.

    A voltage edge excites modes of 50 and 90 Hz that die out within `AFTER_EDGE_S`; steps in that
    time are shorter by `after_edges`. With 2 the force of pulses in contact is within 1e-3 of its
    range, with 1 it is within 3e-3 (steps of 1 ms).
    """

    step_s: float = 1e-3  # the longest
    after_edges: int = 2
    degrees: tuple[int, ...] = (8, 3)  # coefficients of the panels before and beyond the contact
    free_degrees: int = 10  # of the one panel of a free sheet
    line_terms: int = 12
    rho: float = 0.8  # spectral radius at infinite frequency: 1 keeps all energy, 0.6 damps
    break_m: float | None = None  # between the panels; None: where the sheet first touches
    tolerance_per_s2: float = 1e-2  # of the curvature's second derivative, times the length
    keep: int = 25  # steps that share a matrix

    def __post_init__(self) -> None:
        """Refuse what no scheme is."""
        if not 0.0 < self.step_s < np.inf:
            raise ModelError(f"the step must be positive, not {self.step_s:g} s")
        if self.after_edges < 1:
            raise ModelError(
                f"steps after an edge are shorter by 1 or more, not by {self.after_edges:g}"
            )
        if not 0.0 <= self.rho <= 1.0:
            raise ModelError(f"the spectral radius rho must be between 0 and 1, not {self.rho:g}")


def steps(
    begin_s: float, times_s: FloatArray, edges_s: FloatArray, by: Resolution
) -> tuple[FloatArray, Counts]:
    """Return steps that end at all times and edges, and after how many each time comes."""
    near = edges_s[(edges_s > begin_s - AFTER_EDGE_S) & (edges_s < times_s[-1])]
    if not len(near):  # as for every frame of the page, and for a sheet that is let go
        widths = times_s - np.concatenate([[begin_s], times_s[:-1]])
        counts = np.maximum(np.ceil(widths / by.step_s - 1e-6), 0.0).astype(int)
        return np.repeat(widths / np.maximum(counts, 1), counts), np.cumsum(counts)
    knots = np.concatenate([[begin_s], times_s])
    ends = near if by.after_edges == 1 else np.concatenate([near, near + AFTER_EDGE_S])
    ends = ends[(ends > begin_s) & (ends < times_s[-1])]
    knots = np.unique(np.concatenate([knots, ends]))
    widths = np.diff(knots)
    apart = widths > SAME_TIME
    if not apart.all():
        knots = knots[np.concatenate([[True], apart])]
        widths = np.diff(knots)
    counts = np.ceil(widths / _longest(knots[:-1], near, by) - 1e-6).astype(int)
    after = np.zeros(len(counts) + 1, dtype=int)
    np.cumsum(counts, out=after[1:])
    nearest = np.searchsorted(knots, times_s - SAME_TIME)
    return np.repeat(widths / counts, counts), after[np.minimum(nearest, len(after) - 1)]


def _longest(from_s: FloatArray, edges_s: FloatArray, by: Resolution) -> FloatArray | float:
    """Return how long steps may be that begin at or after these times."""
    if by.after_edges == 1:
        return by.step_s
    last = np.searchsorted(edges_s, from_s + SAME_TIME) - 1
    since_s = from_s - edges_s[np.maximum(last, 0)]
    soon = (last >= 0) & (since_s < AFTER_EDGE_S - SAME_TIME)
    return np.where(soon, by.step_s / by.after_edges, by.step_s)
