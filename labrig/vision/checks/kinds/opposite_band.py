"""Whether something stronger of the opposite brightness runs beside the curve."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.checks.contract import CurveCheck, CurveFinding
from labrig.vision.checks.neighbouring_structure import runs_beside_opposite
from labrig.vision.checks.seen_curve import SeenCurve


@dataclass(frozen=True, kw_only=True)
class OppositeBand(CurveCheck):
    """A shadow or a flank was followed."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        if not seen.beside_checked:
            return None
        return self.refuse() if runs_beside_opposite(seen.fit, seen.context) else None


CHECK = OppositeBand(
    name="opposite_band",
    looks_at="bands of the opposite brightness beside the curve",
    refusal="check of the surroundings failed: what was followed runs beside something stronger "
    "of the opposite brightness; it is a shadow or an edge, not the sheet; check polarity and "
    "clamp_px.",
    order=120,
)
