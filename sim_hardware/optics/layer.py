"""Where bands are drawn before they are laid over the picture."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from sim_hardware.optics.geometry import FloatArray

Picture = npt.NDArray[np.float32]


class BandLayer:
    """Collects the coverage and the light of bands, averaged over the instants of an exposure.

    Draw the bands of one instant, which unite; `add` them with the instant's share of the exposure;
    when all instants are in, `lay_over` a picture, which empties the layer. `softness_px` is the
    standard deviation of the edges.
    """

    def __init__(self, columns: int, rows: int, softness_px: float) -> None:
        from sim_hardware.optics import kernels

        self._kernels = kernels
        self._columns = columns
        self._softness_px = softness_px
        pixels = columns * rows
        self._layer = np.full((pixels, 5), np.inf, dtype=np.float32)
        self._hidden = np.zeros(pixels, dtype=np.float32)
        self._light = np.zeros(pixels, dtype=np.float32)
        self._touched = np.zeros(pixels, dtype=np.int32)
        self._count = 0
        self._changed: list[npt.NDArray[np.int32]] = []

    def draw(self, points_px: FloatArray, half_width_px: FloatArray, level: FloatArray) -> None:
        """A band along raw pixels (n, 2) with half widths (n) and grey levels (n)."""
        self._count = self._kernels.draw_band(
            points_px,
            half_width_px,
            level,
            self._softness_px,
            self._layer,
            self._columns,
            self._touched,
            self._count,
        )

    def add(self, share: float) -> None:
        """Count what was drawn since the last call with this share of the exposure."""
        self._kernels.lay_down(
            self._layer,
            self._touched,
            self._count,
            self._softness_px,
            share,
            self._hidden,
            self._light,
        )
        self._changed.append(self._touched[: self._count].copy())
        self._count = 0

    def lay_over(self, picture: Picture) -> None:
        """Lay what was added over a flat picture (rows * columns) and empty the layer."""
        for at in self._changed:  # a pixel met again has nothing left to give
            picture[at] = picture[at] * (1 - self._hidden[at]) + self._light[at]
            self._hidden[at] = 0
            self._light[at] = 0
        self._changed.clear()
