"""The curve of the mean image beside the curves of its frames: whether the sheet held still."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.curve import NeutralCurve

FloatArray = npt.NDArray[np.float64]

# beyond this many standard deviations, and this far, mean image and frames disagree
DISAGREE_SIGMA = 4.0
DISAGREE_PX = 0.15


@dataclass(frozen=True)
class Comparison:
    """Distances along the mean image's normal, at its points (m)."""

    agree: bool
    warnings: tuple[str, ...]
    frames: int  # that gave a curve
    mean_offset_m: FloatArray  # (points,) mean of the frames' curves minus the mean image's
    scatter_m: FloatArray  # (points,) standard deviation from frame to frame
    largest_scatter_m: float


def compare_with_frames(
    mean: NeutralCurve, frames: Sequence[NeutralCurve], px_per_mm: float
) -> Comparison:
    """Compare the curve of the mean image with those of the frames that it is the mean of."""
    good = [f for f in frames if f.ok and len(f.s_m) == len(mean.s_m)]
    if not mean.ok or len(good) < 2:
        return Comparison(
            agree=False,
            warnings=("the mean image or all but one of its frames gave no curve",),
            frames=len(good),
            mean_offset_m=np.empty(0),
            scatter_m=np.empty(0),
            largest_scatter_m=0.0,
        )
    offsets = np.array([_normal_distance(mean, frame) for frame in good])
    centre, scatter = offsets.mean(axis=0), offsets.std(axis=0, ddof=1)
    expected = np.sqrt(mean.sigma_m**2 + scatter**2 / len(good))
    px_m = 1e-3 / px_per_mm
    apart = np.abs(centre) > np.maximum(DISAGREE_SIGMA * expected, DISAGREE_PX * px_m)
    warnings = []
    if apart.mean() > 0.02:
        warnings.append(
            f"the mean image's curve and the mean of its frames' curves differ by up to "
            f"{np.abs(centre).max() * 1e6:.0f} um; the sheet moved between the frames"
        )
    if scatter.max() > 1.5 * px_m:
        warnings.append(
            f"the sheet scatters by {scatter.max() * 1e3:.2f} mm from frame to frame, too much "
            "for their mean image"
        )
    return Comparison(
        not warnings, tuple(warnings), len(good), centre, scatter, float(scatter.max())
    )


def _normal_distance(mean: NeutralCurve, frame: NeutralCurve) -> FloatArray:
    tangent = np.stack([np.gradient(mean.x_m), np.gradient(mean.y_m)], axis=1)
    tangent /= np.hypot(tangent[:, 0], tangent[:, 1])[:, None]
    return np.asarray(
        (frame.y_m - mean.y_m) * tangent[:, 0] - (frame.x_m - mean.x_m) * tangent[:, 1]
    )
