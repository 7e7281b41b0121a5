"""The distortion of a lens, by OpenCV's model."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
CameraMatrix = Sequence[Sequence[float]]


def distorted(
    points_px: FloatArray, camera_matrix: CameraMatrix, distortion: Sequence[float]
) -> FloatArray:
    """Return where a lens shows undistorted pixels (n, 2); `distortion`: k1, k2, p1, p2[, k3]."""
    (fx, skew, cx), (_, fy, cy), _ = camera_matrix
    k1, k2, p1, p2, k3 = (*distortion, 0.0)[:5]
    y = (points_px[:, 1] - cy) / fy
    x = (points_px[:, 0] - cx - skew * y) / fx
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    x_d = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    y_d = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return np.column_stack((fx * x_d + skew * y_d + cx, fy * y_d + cy))
