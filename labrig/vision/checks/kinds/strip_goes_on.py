"""Whether the strip goes on beyond the place where its end was found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

from labrig.vision.checks.around_end import FARTHEST, shown_beyond
from labrig.vision.checks.contract import CheckStage, CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.checks.seen_outline import SeenOutline
from labrig.vision.thresholds import STRIP_GOES_ON_MIN


@dataclass(frozen=True, kw_only=True)
class StripGoesOn(CurveCheck):
    """The curve may be too short, or end on another thing."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        outline = cast("SeenOutline", seen)  # what this stage is asked with
        if not outline.end_measured:
            return None
        context, fit = outline.context, outline.fit
        path_px = context.nodes_px(fit.shape)
        if shown_beyond(context.channels, path_px, fit.width_px) < STRIP_GOES_ON_MIN:
            return None
        u, v = path_px[-1]
        # so far it seems to go on; no further is looked, and it may be another thing
        return self.warn(end_widening_px=FARTHEST * fit.width_px, u=float(u), v=float(v))


CHECK = StripGoesOn(
    name="strip_goes_on",
    looks_at="how much of the strip's profile shows around the end, where that is measured",
    warning="the strip may go on beyond the end of the curve at {u:.0f},{v:.0f}; state the length, "
    "or its tip (--tip-px)",
    stage=CheckStage.OUTLINE,
    order=400,
)
