"""How well the curve is known everywhere, once all that widens its uncertainty is in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from labrig.vision.checks.contract import CheckStage, CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.thresholds import HIDDEN_SIGMA_MAX_PX
from labrig.vision.uncertainty.parts import calibration_m


@dataclass(frozen=True, kw_only=True)
class KnownEverywhere(CurveCheck):
    """Somewhere the curve is known too little to be told from its surroundings."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        if seen.sigma_px is None:
            return None
        shape, optics = seen.fit.shape, seen.context.optics
        ppm = optics.px_per_m
        # a scale that is little known is no fault of the image
        scale = ppm * calibration_m(shape.x / ppm, shape.y / ppm, shape.phi, optics)
        sigma_px = np.sqrt(np.maximum(seen.sigma_px**2 - scale**2, 0.0))
        worst = int(sigma_px.argmax())
        if not sigma_px[worst] > HIDDEN_SIGMA_MAX_PX:
            return None
        return self.refuse(at_px=seen.pixel(worst), loose_px=float(sigma_px[worst]))


CHECK = KnownEverywhere(
    name="known_everywhere",
    looks_at="the standard deviation of the curve, with all that widens it but the calibration",
    refusal="check of the uncertainty failed: the curve is known to ±{loose_px:.1f} pixels only; "
    "check the stated thickness, light the sheet's edge alone, or mask what lies beside it "
    "(--mask).",
    stage=CheckStage.UNCERTAINTY,
    order=320,
)
