"""How much of the sheet is hidden by wires that were left out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from labrig.vision.checks.contract import CheckStage, CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.curve.background_lines import hidden_by
from labrig.vision.thresholds import LINE_COVER_WARNED_SHARE


@dataclass(frozen=True, kw_only=True)
class Wires(CurveCheck):
    """Wires lie along the sheet or cross it."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        if not seen.wires or seen.followed:
            return None
        rows, columns = seen.context.image.grey.shape
        hidden = hidden_by(seen.wires, (rows, columns))
        nodes = np.round(seen.context.nodes_px(seen.fit.shape)).astype(int)
        u, v = np.clip(nodes, 0, (columns - 1, rows - 1)).T
        share = float(hidden[v, u].mean())
        return self.warn(share=share) if share > LINE_COVER_WARNED_SHARE else None


CHECK = Wires(
    name="wires",
    looks_at="the share of the curve on wires whose pixels were left out",
    warning="something such as a wire or a shadow lies along {share:.0%} of the sheet, or crosses "
    "it; it was left out there",
    stage=CheckStage.CHOSEN,
    order=260,
)
