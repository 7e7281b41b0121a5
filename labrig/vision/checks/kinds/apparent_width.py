"""Whether the sheet looks wider than it is thick."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.checks.contract import CheckStage, CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.thresholds import (
    EXCESS_WIDTH_MAX_PX,
    EXCESS_WIDTH_MAX_RATIO,
    EXCESS_WIDTH_WARNED_PX,
)


@dataclass(frozen=True, kw_only=True)
class ApparentWidth(CurveCheck):
    """Half of the excess is unknown."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        excess = seen.along(seen.excess_px)
        widest_px = float(excess.max())
        most = max(EXCESS_WIDTH_MAX_PX, EXCESS_WIDTH_MAX_RATIO * seen.fit.shape.basis.total_px)
        if widest_px > most and not (seen.followed or seen.left_out_along):
            return self.refuse(excess_px=widest_px)
        warned = widest_px > EXCESS_WIDTH_WARNED_PX
        return CurveFinding(
            warning=self.warning.format(excess_px=widest_px) if warned else "",
            widening_px=excess / 2,
        )


CHECK = ApparentWidth(
    name="apparent_width",
    looks_at="the visible width of the sheet beyond its thickness",
    refusal="check of the width failed: what was followed looks up to {excess_px:.1f} pixels "
    "wider than the sheet is thick, and nothing shows which part of it is the sheet's edge; "
    "light the edge, or check the sheet's thickness.",
    warning="the sheet looks, or may look, up to {excess_px:.1f} pixels wider than it is thick; "
    "its face is seen with its edge, or it is out of focus; the curve may be off by half of that",
    stage=CheckStage.CHOSEN,
    order=220,
)
