"""Whether the sheet ends where its stated length and the scale put its end."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.checks.continuation import visible_continuation_px
from labrig.vision.checks.contract import CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve
from labrig.vision.checks.sheet_end import SheetEnd, missing_end_px
from labrig.vision.thresholds import END_OFFSET_WARNED_PX, UNSEEN_END_MAX_PX


@dataclass(frozen=True, kw_only=True)
class EndPlace(CurveCheck):
    """The sheet ends elsewhere."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        return CurveFinding(refusal=self._refusal(seen), warning=self._warning(seen))

    def _refusal(self, seen: SeenCurve) -> str:
        end = seen.sheet_end if seen.followed else _further(seen)
        tip_px = end.beyond_px if end.beyond_px is not None else -missing_end_px(seen.fit)
        if abs(tip_px) <= (UNSEEN_END_MAX_PX if end.at_least else seen.length_error_max_px):
            return ""
        return self.refusal.format(
            at_least="at least " if end.at_least else "",
            tip_mm=abs(tip_px) / seen.context.optics.px_per_mm,
            side="after" if tip_px > 0 else "before",
            length_mm=seen.length_mm,
        )

    def _warning(self, seen: SeenCurve) -> str:
        beyond_px = seen.sheet_end.beyond_px
        if beyond_px is None or abs(beyond_px) <= END_OFFSET_WARNED_PX:
            return ""
        return self.warning.format(beyond_mm=beyond_px / seen.context.optics.px_per_mm)


def _further(seen: SeenCurve) -> SheetEnd:
    """Return the end as it is seen, or that the sheet continues far beyond where it should end."""
    end, allowed = seen.sheet_end, seen.length_error_max_px
    if end.at_least or (end.beyond_px is not None and abs(end.beyond_px) > allowed):
        return end
    beyond = visible_continuation_px(seen.fit, seen.context)
    return SheetEnd(beyond, at_least=True) if beyond > allowed else end


CHECK = EndPlace(
    name="end_place",
    looks_at="the place where the sheet is seen to end, or to continue",
    refusal="check of the end failed: the sheet ends {at_least}{tip_mm:.1f} mm {side} the stated "
    "{length_mm:.1f} mm; px_per_mm or the sheet's length is wrong.",
    warning="the sheet's end is seen {beyond_mm:+.2f} mm from where length and scale put it",
    order=130,
)
