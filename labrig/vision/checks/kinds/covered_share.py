"""How much of the curve looks like the sheet."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.checks.contract import CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.thresholds import COVERED_SHARE_MIN, COVERED_SHARE_WARNED


@dataclass(frozen=True, kw_only=True)
class CoveredShare(CurveCheck):
    """Too little of the curve looks like the sheet."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        share, hidden = seen.seen_share(slice(2, -2)), 1 - seen.covered
        refusal = self.refusal.format(seen=share) if share < COVERED_SHARE_MIN else ""
        warned = seen.covered < COVERED_SHARE_WARNED
        return CurveFinding(
            refusal=refusal, warning=self.warning.format(hidden=hidden) if warned else ""
        )


CHECK = CoveredShare(
    name="covered_share",
    looks_at="the share of the curve that looks like the sheet",
    refusal="search failed: no sheet was found that starts at the clamp: only {seen:.0%} of the "
    "best path looks like one; check the image, clamp_px and the sheet's length.",
    warning="the sheet is hidden or unclear on {hidden:.0%} of its length",
    order=30,
)
