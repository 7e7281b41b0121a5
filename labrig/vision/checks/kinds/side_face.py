"""Whether the sheet's side face shows beside its edge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from labrig.vision.checks.contract import CheckStage, CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.thresholds import EXCESS_WIDTH_WARNED_PX


@dataclass(frozen=True, kw_only=True)
class SideFaceShows(CurveCheck):
    """The fit separated the face from the edge."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        section = seen.fit.section
        share = section.side_face_share
        face_px = float(np.abs(section.side_face).max()) if share > 0 else 0.0
        if face_px * share <= EXCESS_WIDTH_WARNED_PX:
            return None
        return self.warn(face_px=face_px, share=share)


CHECK = SideFaceShows(
    name="side_face",
    looks_at="the width and the grey of the side face that the fit separated",
    warning="the sheet's side face shows beside its edge, up to {face_px:.1f} pixels wide and "
    "{share:.0%} as strong; it was separated from the edge and left out",
    stage=CheckStage.CHOSEN,
    order=250,
)
