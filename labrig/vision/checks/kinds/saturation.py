"""Whether parts of the image are saturated where the sheet is bright."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.checks.contract import CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.thresholds import SATURATED_SHARE_WARNED


@dataclass(frozen=True, kw_only=True)
class Saturation(CurveCheck):
    """A bright sheet may be saturated."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        bright, clipped = seen.context.sign > 0, seen.context.image.clipped
        return self.warn() if bright and clipped > SATURATED_SHARE_WARNED else None


CHECK = Saturation(
    name="saturation",
    looks_at="the share of pixels at full scale",
    warning="parts of the image are saturated",
    order=150,
)
