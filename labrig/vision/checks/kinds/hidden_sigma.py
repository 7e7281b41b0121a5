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
        loose_px = float(spread(fit.shape.normal_modes(), fit.cautious_covariance).max())
        return self.refuse(loose_px=loose_px) if loose_px > HIDDEN_SIGMA_MAX_PX else None


CHECK = HiddenSigma(
    name="hidden_sigma",
    looks_at="the standard deviation of the curve where the sheet is hidden or unclear",
    refusal="check of hidden parts failed: where the sheet is hidden or unclear it is known to "
    "±{loose_px:.1f} pixels only; make more of it visible.",
    order=70,
)
