"""Whether the elongation bends, and by no more than one can."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from labrig.vision.checks.contract import CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.thresholds import ELONGATION_TURN_MAX_RAD


@dataclass(frozen=True, kw_only=True)
class ElongationBend(CurveCheck):
    """No straight elongation fits the image, and one that bends does."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        shape = seen.fit.shape
        if not shape.basis.rest_bends:
            return None
        # the last node before the joint has no part of its turn
        first = int(np.searchsorted(shape.basis.s, shape.basis.free_px, side="right")) - 1
        turn_mrad = 1e3 * float(np.ptp(shape.phi[first:]))
        if turn_mrad > 1e3 * ELONGATION_TURN_MAX_RAD:
            return self.refuse(turn_mrad=turn_mrad)
        return self.warn(turn_mrad=turn_mrad)


CHECK = ElongationBend(
    name="elongation_bend",
    looks_at="how far the direction changes along an elongation that is not straight",
    refusal="check of the fit failed: the elongation would turn by {turn_mrad:.0f} mrad, more than "
    "one can; check the sheet's free length, or mask what crosses it (--mask).",
    warning="no straight elongation fits the image; that of the curve turns by {turn_mrad:.0f} "
    "mrad",
    order=105,
)
