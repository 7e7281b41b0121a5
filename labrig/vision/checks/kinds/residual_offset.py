"""Whether what looks like the sheet lies beside the curve."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.checks.contract import CheckStage, CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.thresholds import OFFSET_WARNED_PX


@dataclass(frozen=True, kw_only=True)
class ResidualOffset(CurveCheck):
    """A frayed sheet, for example."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        most = float(seen.offset_px.max())
        warned = most > OFFSET_WARNED_PX
        return CurveFinding(
            warning=self.warning.format(offset_px=most) if warned else "",
            widening_px=seen.offset_px,
        )


CHECK = ResidualOffset(
    name="residual_offset",
    looks_at="the mean offset of neighbouring pieces of the sheet from the curve",
    warning="what looks like the sheet lies up to {offset_px:.1f} pixels beside the curve where "
    "it is not as thick or as smooth as a sheet; the credible band holds both",
    stage=CheckStage.CHOSEN,
    order=240,
)
