"""Whether the edge of something wide was followed."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.checks.contract import CurveCheck, CurveFinding
from labrig.vision.checks.neighbouring_structure import is_an_edge
from labrig.vision.checks.seen_curve import SeenCurve


@dataclass(frozen=True, kw_only=True)
class WideEdge(CurveCheck):
    """One side of the curve is as bright as the curve."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        if not seen.beside_checked or seen.followed:
            return None
        return self.refuse() if is_an_edge(seen.fit, seen.context) else None


CHECK = WideEdge(
    name="wide_edge",
    looks_at="the greys on both sides of the curve",
    refusal="check of the surroundings failed: what was followed is the edge of something wide, "
    "not a sheet; check clamp_px.",
    order=110,
)
