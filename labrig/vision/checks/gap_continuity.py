"""Compare the curve after a hidden stretch with a prediction from before it.

A line that happens to leave a roll where the sheet does is led into by a sharp turn that nobody
sees. So each stretch is compared with the prediction from the sheet before it, whose curvature may
continue to change as it does there, and with what a force behind a roll may add.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.curve.shape import CurveShape
from labrig.vision.curve.smoothness import averaged, covariance
from labrig.vision.fit.context import FitContext
from labrig.vision.fit.curve_fit import CurveFit, around, information
from labrig.vision.thresholds import (
    GAP_CELLS_BEFORE_MIN,
    GAP_CHI2_WARNED,
    GAP_LENGTH_MIN_PX,
    HOLE_CONTRAST_MAX_RATIO,
    HOLE_MIN_SIGMAS,
)

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

LOCAL_CELLS = 3  # to each side: a hole is shorter than what contrast is measured in
# what hides the sheet may pull its place (pixels), direction and curvature (per pixel) beside it
GAP_EDGE_SIGMAS = np.array([0.2, 0.015, 5e-4])


@dataclass(frozen=True, eq=False)
class GapJoin:
    """How what is seen beyond a hidden stretch lies beside what was to be expected there."""

    offset_px: float = 0.0
    turn_rad: float = 0.0
    chi2: float = 0.0  # of both and of curvature, by how well they can be predicted
    deviation_px: FloatArray | None = (
        None  # (nodes,) from the curve to where it would go without it
    )

    @property
    def doubtful(self) -> bool:
        """Whether something else may have been followed there."""
        return self.chi2 > GAP_CHI2_WARNED


def worst_join(fit: CurveFit, context: FitContext) -> GapJoin:
    """Return the least likely of a curve's joins."""
    shape, step = fit.shape, fit.shape.basis.step_px
    seen = np.flatnonzero(fit.used & ~holes(fit, context))
    gaps = np.flatnonzero(np.diff(seen) * step > GAP_LENGTH_MIN_PX)
    gaps = gaps[gaps + 1 >= GAP_CELLS_BEFORE_MIN]
    if not len(gaps):
        return GapJoin()
    modes = shape.normal_modes()
    joins = [_join(fit, context, modes, int(seen[i]) + 1, int(seen[i + 1])) for i in gaps]
    return max(joins, key=lambda join: join.chi2)


def holes(fit: CurveFit, context: FitContext) -> BoolArray:
    """Return (cells,) where nothing like the sheet is, whatever is seen around it."""
    residual_squares, size = (around(fit.cells[:, q], LOCAL_CELLS) for q in (10, 11))
    size = np.maximum(size, 1e-9)
    there = context.sign * (fit.contrast + residual_squares / size)
    hole = np.zeros(len(there), dtype=bool)
    for part in (fit.section.elongation, ~fit.section.elongation):
        if (fit.used & part).any():
            usual = float(np.median(np.abs(fit.contrast[fit.used & part])))
            significant = usual - there > HOLE_MIN_SIGMAS * fit.noise / np.sqrt(size)
            hole |= part & significant & (there < HOLE_CONTRAST_MAX_RATIO * usual)
    # what is left of the sheet in the windows makes holes look shorter
    return around(hole, 1) > 0.5


def _join(fit: CurveFit, context: FitContext, modes: FloatArray, until: int, again: int) -> GapJoin:
    """Return the join of the cells seen up to `until` with those that are seen from `again` on."""
    shape, basis = fit.shape, fit.shape.basis
    offset, sigma = fit.offsets_px
    weight = np.where(fit.used, 1 / sigma**2, 0.0)[:until]
    before = 0.5 * (modes[1 : until + 1] + modes[:until])
    normal, pull = information(shape, before, offset[:until], weight, context.prior)
    rows = np.zeros((3, basis.size))
    rows[0] = modes[again]
    rows[1, 1], rows[1, 2:] = 1.0, basis.angle[again]
    rows[2, 2:] = basis.curvature[again]
    predicted = averaged(normal, pull, basis.priors, basis.log_weight)
    prediction_covariance = (
        covariance(normal, pull, basis.priors, basis.log_weight) + fit.covariance
    )
    change = shape.parameters - predicted
    off = rows @ change
    pushed = _pushed(shape, until, again)
    known = (
        rows @ prediction_covariance @ rows.T
        + np.outer(pushed, pushed)
        + np.diag(GAP_EDGE_SIGMAS**2)
    )
    aside = np.where(np.arange(len(modes)) < until, 0.0, modes @ change)
    return GapJoin(float(off[0]), float(off[1]), float(off @ np.linalg.solve(known, off)), aside)


def _pushed(shape: CurveShape, until: int, again: int) -> FloatArray:
    """Return (3,) the change of place, direction and curvature by a force in the hidden stretch.

    A force bends a sheet in proportion to the distance from it, so it ends a slope of curvature.
    """
    step = shape.basis.step_px
    slope = float(np.abs(shape.k[: again + 1]).max()) / (until * step)
    hidden = (again - until) * step
    return slope * hidden * np.array([hidden**2 / 6, hidden / 2, 1.0])
