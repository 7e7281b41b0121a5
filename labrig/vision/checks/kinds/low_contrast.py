"""Whether the sheet stands out of the noise."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.checks.contract import CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.thresholds import SNR_MIN


@dataclass(frozen=True, kw_only=True)
class LowContrast(CurveCheck):
    """The contrast is too low."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        snr = seen.fit.usual_contrast / seen.fit.noise
        return self.refuse(snr=snr, least=SNR_MIN) if snr < SNR_MIN else None


CHECK = LowContrast(
    name="low_contrast",
    looks_at="the sheet's contrast over the noise of a pixel",
    refusal="check of the contrast failed: the contrast is too low: {snr:.1f} times the noise, "
    "at least {least:g} is needed.",
    order=60,
)
