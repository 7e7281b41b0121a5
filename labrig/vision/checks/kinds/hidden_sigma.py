"""How well the curve is known where the sheet is hidden or unclear."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.checks.contract import CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.fit.curve_fit import spread
from labrig.vision.thresholds import FULLY_SEEN_SHARE, HIDDEN_SIGMA_MAX_PX


@dataclass(frozen=True, kw_only=True)
class HiddenSigma(CurveCheck):
    """A hidden stretch is too long to be bridged."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        fit = seen.fit
        if fit.used.mean() > FULLY_SEEN_SHARE:
            return None
        sigma_px = spread(fit.shape.normal_modes(), fit.cautious_covariance)
        worst = int(sigma_px.argmax())
        if not sigma_px[worst] > HIDDEN_SIGMA_MAX_PX:
            return None
        return self.refuse(at_px=seen.pixel(worst), loose_px=float(sigma_px[worst]))


CHECK = HiddenSigma(
    name="hidden_sigma",
    looks_at="the standard deviation of the curve where the sheet is hidden or unclear",
    refusal="check of hidden parts failed: where the sheet is hidden or unclear it is known to "
    "±{loose_px:.1f} pixels only; make more of it visible.",
    order=70,
)
