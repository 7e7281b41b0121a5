"""OpenCV's lens model on points: distort directly, undistort by Newton's method.

Written out here because `cv2.undistortPoints` stops at about 1e-3 pixels by default and its
arguments differ between OpenCV 4 and 5.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


def distort(points_px: FloatArray, camera: FloatArray, coefficients: FloatArray) -> FloatArray:
    """Return ideal pixels (n, 2) -> the pixels where the lens shows them."""
    focal, centre = _intrinsics(camera)
    bent, _ = _bend((points_px - centre) / focal, _eight(coefficients))
    return bent * focal + centre


def undistort(points_px: FloatArray, camera: FloatArray, coefficients: FloatArray) -> FloatArray:
    """Return raw pixels (n, 2) -> ideal pixels, to 1e-9 of the focal length."""
    focal, centre = _intrinsics(camera)
    k = _eight(coefficients)
    wanted = (points_px - centre) / focal
    point = wanted.copy()
    for _ in range(20):
        bent, jacobian = _bend(point, k)
        miss = bent - wanted
        a, b, c, d = jacobian
        determinant = a * d - b * c
        step_x = (d * miss[:, 0] - b * miss[:, 1]) / determinant
        step_y = (a * miss[:, 1] - c * miss[:, 0]) / determinant
        point = point - np.stack([step_x, step_y], axis=1)
        if np.all(np.abs(miss) < 1e-10):
            break
    return point * focal + centre


def _intrinsics(camera: FloatArray) -> tuple[FloatArray, FloatArray]:
    return np.array([camera[0, 0], camera[1, 1]]), np.array([camera[0, 2], camera[1, 2]])


def _eight(coefficients: FloatArray) -> FloatArray:
    return np.concatenate([coefficients, np.zeros(8)])[:8]


def _bend(point: FloatArray, k: FloatArray) -> tuple[FloatArray, tuple[FloatArray, ...]]:
    """Return the lens on normalised points (n, 2), and the four entries of its Jacobian."""
    k1, k2, p1, p2, k3, k4, k5, k6 = k
    x, y = point[:, 0], point[:, 1]
    r2 = x * x + y * y
    top = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    bottom = 1 + r2 * (k4 + r2 * (k5 + r2 * k6))
    radial = top / bottom
    # derivative of the radial factor with respect to r^2
    slope_top = k1 + r2 * (2 * k2 + 3 * r2 * k3)
    slope_bottom = k4 + r2 * (2 * k5 + 3 * r2 * k6)
    slope = (slope_top - radial * slope_bottom) / bottom
    bent = np.stack(
        [
            x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
        ],
        axis=1,
    )
    xx = radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x
    xy = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y
    yy = radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x
    return bent, (xx, xy, xy, yy)
