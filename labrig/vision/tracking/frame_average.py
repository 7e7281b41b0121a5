"""Compare the curve of a mean image with those of its frames, to see whether the sheet moved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.curve import NeutralCurve
from labrig.vision.thresholds import (
    FRAME_DISTANCE_WARNED_PX,
    FRAME_DISTANCE_WARNED_SIGMAS,
    FRAME_SCATTER_WARNED_PX,
)
from model.measurements import Curve

FloatArray = npt.NDArray[np.float64]
Line = NeutralCurve | Curve


@dataclass(frozen=True, eq=False, kw_only=True)
class FrameAverage:
    """The mean of the single frames' curves; arrays are (points,)."""

    frames: int
    s_m: FloatArray
    x_m: FloatArray
    y_m: FloatArray
    scatter_m: FloatArray  # standard deviation along the normal, from frame to frame

    @property
    def scatter_rms_m(self) -> float:
        """Over the whole curve."""
        return float(np.sqrt(np.mean(self.scatter_m**2)))

    def apart_m(self, other: Line) -> float:
        """Return RMS distance of another curve from this one, along the normal."""
        s = self.s_m[self.s_m <= other.s_m[-1]]
        x, y = self.x_m[: s.size], self.y_m[: s.size]
        dx, dy = np.interp(s, other.s_m, other.x_m) - x, np.interp(s, other.s_m, other.y_m) - y
        return float(np.sqrt(np.mean(_across(x, y, dx, dy) ** 2)))


@dataclass(frozen=True, eq=False)
class Comparison:
    """The average of the frames' curves, and its distance from the mean image's."""

    average: FrameAverage | None  # None: fewer than two frames gave a curve
    apart_m: float | None  # frames' mean to mean image, RMS; None: one of them has no curve
    warnings: tuple[str, ...]

    @property
    def agree(self) -> bool:
        """Whether both methods gave a curve, and the same one."""
        return self.apart_m is not None and not self.warnings


def average_of_frames(frames: Sequence[Line]) -> FrameAverage | None:
    """Return the frames' curves averaged point by point, with their scatter.

    None for less than two.
    """
    good = [curve for curve in frames if curve.s_m.size]
    if len(good) < 2:
        return None
    shortest = min(good, key=lambda curve: float(curve.s_m[-1]))
    s = shortest.s_m
    x = np.array([np.interp(s, curve.s_m, curve.x_m) for curve in good])
    y = np.array([np.interp(s, curve.s_m, curve.y_m) for curve in good])
    middle_x, middle_y = x.mean(axis=0), y.mean(axis=0)
    across = _across(middle_x, middle_y, x - middle_x, y - middle_y)
    return FrameAverage(
        frames=len(good), s_m=s, x_m=middle_x, y_m=middle_y, scatter_m=across.std(axis=0, ddof=1)
    )


def compare_with_frames(mean: Line | None, frames: Sequence[Line], px_per_mm: float) -> Comparison:
    """Compare the curve of a mean image (None: it has none) with those of its frames.

    Frames without a curve are left out. A sheet that moved is recognised from the frames alone.
    """
    average = average_of_frames(frames)
    if average is None:
        return Comparison(None, None, ("fewer than two frames gave a curve",))
    apart = None if mean is None or not mean.s_m.size else average.apart_m(mean)
    scatter, px_m = average.scatter_rms_m, 1e-3 / px_per_mm
    warnings = []
    if scatter > FRAME_SCATTER_WARNED_PX * px_m:
        warnings.append(
            f"the curves of the single frames scatter by {scatter * 1e3:.3f} mm (RMS), so the "
            "sheet moved between them; trust their mean more than the mean image"
        )
    elif apart is not None and (
        apart
        > FRAME_DISTANCE_WARNED_PX * px_m
        + FRAME_DISTANCE_WARNED_SIGMAS * scatter / average.frames**0.5
    ):
        warnings.append(
            f"the mean image's curve lies {apart * 1e3:.3f} mm (RMS) from the mean of the curves "
            "of its frames; check both"
        )
    return Comparison(average, apart, tuple(warnings))


def _across(x: FloatArray, y: FloatArray, dx: FloatArray, dy: FloatArray) -> FloatArray:
    """Return (..., points) the part of (dx, dy) along the normal of the curve (x, y)."""
    tx, ty = np.gradient(x), np.gradient(y)
    length = np.hypot(tx, ty)
    return np.asarray((dy * tx - dx * ty) / length)
