"""Whether what is seen beyond a hidden stretch continues what is seen before it."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.checks.contract import CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.thresholds import END_IN_PLACE_CHI2, END_IN_PLACE_MAX_PX, GAP_CHI2_MAX


@dataclass(frozen=True, kw_only=True)
class JoinOverGap(CurveCheck):
    """Something else was followed beyond a hidden stretch."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        join = seen.join
        offset_px, turn_rad = abs(join.offset_px), abs(join.turn_rad)
        refusal, warning, deviation_px = "", "", None
        if join.chi2 > GAP_CHI2_MAX + (END_IN_PLACE_CHI2 if _ends_in_place(seen) else 0.0):
            refusal = self.refusal.format(offset_px=offset_px, turn_rad=turn_rad)
        if join.doubtful:
            warning = self.warning.format(offset_px=offset_px)
            deviation_px = join.deviation_px
        return CurveFinding(refusal=refusal, warning=warning, widening_px=deviation_px)


def _ends_in_place(seen: SeenCurve) -> bool:
    beyond_px = seen.sheet_end.beyond_px
    return beyond_px is not None and abs(beyond_px) < END_IN_PLACE_MAX_PX


CHECK = JoinOverGap(
    name="gap_join",
    looks_at="place, direction and curvature beyond a hidden stretch against those before it",
    refusal="check of hidden parts failed: what is seen beyond a hidden stretch is "
    "{offset_px:.1f} pixels and {turn_rad:.2f} rad beside where the sheet before it leads; "
    "something else was followed there; make more of the sheet visible.",
    warning="what is seen beyond a hidden stretch is {offset_px:.1f} pixels beside where the "
    "sheet before it leads; the credible band holds both",
    order=140,
)
