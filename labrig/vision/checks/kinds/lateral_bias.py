"""Whether something touches the sheet on one side and pulls the curve."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.checks.contract import CheckStage, CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.thresholds import BIAS_WARNED_PX


@dataclass(frozen=True, kw_only=True)
class LateralBias(CurveCheck):
    """A reflection, for example."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        bias = seen.along(seen.lateral_bias_px)
        most = float(bias.max())
        warned = most > BIAS_WARNED_PX
        return CurveFinding(
            warning=self.warning.format(bias_px=most) if warned else "", widening_px=bias
        )


CHECK = LateralBias(
    name="lateral_bias",
    looks_at="light on one side of the sheet that neither displacement nor blur explains",
    warning="something touches the sheet on one side, such as its reflection, and may pull the "
    "curve by up to {bias_px:.2f} pixels; the credible band holds it",
    stage=CheckStage.CHOSEN,
    order=230,
)
