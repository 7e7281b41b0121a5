"""How much of the curve is hidden by what is known to hide it."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.checks.contract import CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.thresholds import IN_VIEW_SHARE_MIN


@dataclass(frozen=True, kw_only=True)
class HiddenShare(CurveCheck):
    """Rolls, wires or a mask hide most of the curve."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        in_view = float(seen.fit.in_view[2:-2].mean())
        return self.refuse(in_view=in_view) if in_view < IN_VIEW_SHARE_MIN else None


CHECK = HiddenShare(
    name="hidden_share",
    looks_at="the share of the curve that nothing known hides",
    refusal="check of hidden parts failed: rolls, wires or the mask hide all but {in_view:.0%} of "
    "the best path; take away what hides the sheet.",
    order=20,
)
