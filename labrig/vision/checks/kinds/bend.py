"""Whether the curve bends more than a sheet can."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from labrig.vision.checks.contract import CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.curve import smallness
from labrig.vision.thresholds import CURVATURE_MAX_PER_M, CURVATURE_REFUSED_RATIO


@dataclass(frozen=True, kw_only=True)
class Bend(CurveCheck):
    """The curve bends too much."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        steepest = float(np.abs(seen.fit.shape.k).max()) * seen.context.optics.px_per_m
        most = CURVATURE_REFUSED_RATIO * CURVATURE_MAX_PER_M * smallness(seen.length_mm / 1000)
        return self.refuse(steepest=steepest) if steepest > most else None


CHECK = Bend(
    name="bend",
    looks_at="the largest curvature",
    refusal="check of the fit failed: the best curve bends by {steepest:.0f} per m, more than a "
    "sheet can; check px_per_mm and clamp_px, or mask what crosses the sheet (--mask).",
    order=100,
)
