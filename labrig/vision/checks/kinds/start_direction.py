"""Whether the sheet leads to the clamp."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from labrig.vision.checks.contract import CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.fit.curve_fit import seen_start
from labrig.vision.thresholds import CLAMP_KINK_SIGMA_RAD, START_CHI2_MAX


@dataclass(frozen=True, kw_only=True)
class StartDirection(CurveCheck):
    """What is seen of the sheet, led on to the clamp, arrives beside it."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        beside, covariance = seen_start(seen.fit, seen.context)
        clamp = np.diag(seen.context.prior**2 + np.array([0.0, CLAMP_KINK_SIGMA_RAD**2]))
        chi2 = float(beside @ np.linalg.solve(covariance + clamp, beside))
        if not chi2 > START_CHI2_MAX:
            return None
        return self.refuse(start_px=float(beside[0]), start_rad=float(beside[1]))


CHECK = StartDirection(
    name="start_direction",
    looks_at="place and angle at the clamp of the curve without the clamp's calibration",
    refusal="check of the start failed: what was followed leads {start_px:.1f} pixels and "
    "{start_rad:.2f} rad beside the clamp; check clamp_px and clamp_angle_rad.",
    order=90,
)
