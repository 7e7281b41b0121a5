"""Whether a second sheet leaves the clamp beside the one that was found."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.checks.contract import CheckStage, CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.thresholds import REFLECTION_CONTRAST_MAX_RATIO


@dataclass(frozen=True, kw_only=True)
class SecondSheet(CurveCheck):
    """Two sheets, or one and its reflection."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        if seen.second_sheet > REFLECTION_CONTRAST_MAX_RATIO:
            return self.refuse()
        return self.warn(share=seen.second_sheet) if seen.second_sheet > 0 else None


CHECK = SecondSheet(
    name="second_sheet",
    looks_at="the contrast of a second path from the clamp over that of the first",
    refusal="check of the surroundings failed: two sheets leave the clamp side by side, and "
    "nothing shows which is meant; take one away, or mask it (--mask).",
    warning="something like the sheet, {share:.0%} as strong, lies beside it, such as its "
    "reflection; the stronger of the two was followed",
    stage=CheckStage.CHOSEN,
    order=210,
)
