"""Whether the first pixels of the curve look like the sheet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from labrig.vision.checks.contract import CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.thresholds import START_COVERED_SHARE_MIN

BRIGHT_CELLS_SHARE = 0.75
CONTRAST_RATIO = 0.4  # to the sheet's


@dataclass(frozen=True, kw_only=True)
class StartUnlike(CurveCheck):
    """The start of the curve does not look like the sheet."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        start = seen.start_cells
        if seen.seen_share(slice(2, start)) >= START_COVERED_SHARE_MIN or _shows(seen, start):
            return None
        return self.refuse(start=start)


def _shows(seen: SeenCurve, start: int) -> bool:
    """Return whether something of the sheet's brightness, but not its width, leaves the clamp."""
    contrast = seen.context.sign * seen.fit.contrast
    used = seen.fit.used
    usual = float(np.median(contrast[used])) if used.any() else np.inf
    return bool(np.mean(contrast[2:start] > CONTRAST_RATIO * usual) > BRIGHT_CELLS_SHARE)


CHECK = StartUnlike(
    name="start_unlike",
    looks_at="the first eighth of the curve",
    refusal="check of the start failed: no sheet was found at the clamp: the first {start} pixels "
    "of the best path do not look like one; check clamp_px.",
    order=40,
)
