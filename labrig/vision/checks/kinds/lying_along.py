"""Whether the curve is known without the cells where something lies along the sheet."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.checks.contract import CheckStage, CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.thresholds import BRIDGED_SIGMA_MAX_PX
from labrig.vision.uncertainty.apparent_width import something_lies_along


@dataclass(frozen=True, kw_only=True)
class LyingAlong(CurveCheck):
    """A wire beside the sheet makes it look wider in one place."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        if not seen.left_out_along:
            return None
        loose = seen.along(seen.sigma_px).max() > BRIDGED_SIGMA_MAX_PX
        remains = something_lies_along(seen.along(seen.excess_px), seen.fit)
        return self.refuse() if loose or remains else self.warn()


CHECK = LyingAlong(
    name="lying_along",
    looks_at="the uncertainty of the curve without the cells beside which something lies",
    refusal="check of the width failed: something lies along the sheet and cannot be separated "
    "from it, such as a wire or a shadow; take it away, or mask it (--mask).",
    warning="something such as a wire or a shadow lies along the sheet; it was left out there",
    stage=CheckStage.UNCERTAINTY,
    order=310,
)
