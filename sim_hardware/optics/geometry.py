"""From the sheet's plane to pixels, and the sheet's curve as a polyline in pixels."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from sim_hardware.optics.settings import OpticsSettings

FloatArray = npt.NDArray[np.float64]


class Geometry:
    """The map from world points (m; x along the clamped sheet, y up) to raw pixels (u, v)."""

    def __init__(self, settings: OpticsSettings) -> None:
        self.px_per_m = settings.px_per_mm * 1000
        self._origin_px = np.array(settings.origin_px)
        cos, sin = math.cos(settings.roll_rad), math.sin(settings.roll_rad)
        # R(roll) acts on (x, -y): the image's v runs down.
        self._matrix = self.px_per_m * np.array([[cos, sin], [sin, -cos]])
        self._lens = settings.lens
        columns, rows = settings.image_size
        self.centre_px = np.array([(columns - 1) / 2, (rows - 1) / 2])
        if self._lens is not None:
            self.centre_px = np.array([self._lens.camera_matrix[k][2] for k in (0, 1)])

    def to_pixels(self, points_m: npt.ArrayLike) -> FloatArray:
        """Raw pixels (n, 2) of world points (n, 2) in m."""
        return self.distort(self.to_undistorted(points_m))

    def to_undistorted(self, points_m: npt.ArrayLike) -> FloatArray:
        """Pixels of a lens without distortion."""
        return self._origin_px + np.asarray(points_m, dtype=np.float64) @ self._matrix.T

    def distort(self, points_px: FloatArray) -> FloatArray:
        """Return where the lens shows undistorted pixels (n, 2)."""
        return points_px if self._lens is None else self._lens.distort(points_px)

    def turned(self, angle_rad: float) -> FloatArray:
        """Return the unit vector in pixels of a world direction, counter-clockwise from x."""
        direction = self._matrix @ np.array([math.cos(angle_rad), math.sin(angle_rad)])
        return np.asarray(direction / self.px_per_m, dtype=np.float64)


def smooth_polyline(shape_m: npt.ArrayLike, spacing_m: float) -> tuple[FloatArray, FloatArray]:
    """Resample a curve (n, 2) by a cubic spline: points (m, 2) and their arc length (m).

    The samples may be as coarse as the links of a chain; the spacing wanted is about a pixel, so
    that straight pieces between the points are good to a thousandth of one.
    """
    from sim_hardware.optics.spline import spline

    shape = np.asarray(shape_m, dtype=np.float64)
    if shape.ndim != 2 or shape.shape[1] != 2 or not np.all(np.isfinite(shape)):
        raise ValueError(f"a shape is an array (n, 2) of finite numbers, not {shape.shape}")
    steps = np.hypot(*np.diff(shape, axis=0).T)
    shape = shape[np.concatenate(([True], steps > 0))]
    if len(shape) < 2:
        raise ValueError("a shape needs at least two different points")
    length = np.concatenate(([0.0], np.cumsum(steps[steps > 0])))
    at = np.linspace(0.0, length[-1], max(2, math.ceil(length[-1] / spacing_m) + 1))
    return spline(length, np.ascontiguousarray(shape), at), at
