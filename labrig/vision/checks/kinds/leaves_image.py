"""Whether the curve ends inside of the image."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.checks.contract import CurveCheck, CurveFinding
from labrig.vision.checks.seen_curve import SeenCurve

BORDER_PX = 3
BORDER_OUT_OF_SIGHT_PX = 8  # where the sheet is seen up to the border


@dataclass(frozen=True, kw_only=True)
class LeavesImage(CurveCheck):
    """The sheet leaves the image before its end."""

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """See `CurveCheck.finding`."""
        end_u, end_v = seen.context.nodes_px(seen.fit.shape)[-1]
        rows, columns = seen.context.image.grey.shape
        near = BORDER_OUT_OF_SIGHT_PX if seen.sheet_end.out_of_sight else BORDER_PX
        if near < end_u < columns - near - 1 and near < end_v < rows - near - 1:
            return None
        return self.refuse(length_mm=seen.length_mm)


CHECK = LeavesImage(
    name="leaves_image",
    looks_at="the place of the curve's end in the image",
    refusal="check of the end failed: the sheet leaves the image: its end, {length_mm:.1f} mm "
    "along the best path, is outside or at the border; move the camera or check clamp_px, "
    "px_per_mm and the sheet's length.",
    order=10,
)
