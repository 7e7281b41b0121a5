"""Whether there is plain background where the curve begins."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.checks.contract import CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.checks.sheet_end import missing_start_px


@dataclass(frozen=True, kw_only=True)
class StartBackground(CurveCheck):
    """The sheet does not begin at the clamp."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        late_px = missing_start_px(seen.fit, seen.context)
        return self.refuse(late_px=late_px) if late_px > 0 else None


CHECK = StartBackground(
    name="start_background",
    looks_at="the background on the first pixels of the curve",
    refusal="check of the start failed: there is plain background on the first {late_px:.0f} "
    "pixels of the best path; the sheet does not begin at the clamp, or something else was "
    "followed; check clamp_px.",
    order=50,
)
