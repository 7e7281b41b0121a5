"""How far the curve misses what it follows."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.checks.contract import CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.thresholds import RESIDUAL_MAX_PX


@dataclass(frozen=True, kw_only=True)
class Residual(CurveCheck):
    """The curve misses the sheet."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        thin = max(1.0, 2 * float(seen.fit.section.half_width[0]) / 3)
        if not seen.residual_px > RESIDUAL_MAX_PX * thin:
            return None
        return self.refuse(residual_px=seen.residual_px)


CHECK = Residual(
    name="residual",
    looks_at="the RMS distance between the curve and the sheet as measured in pieces",
    refusal="check of the fit failed: the best curve misses the sheet by {residual_px:.2f} "
    "pixels; something else was followed: check clamp_px and the sheet's length, or mask what "
    "crosses it (--mask).",
    order=80,
)
