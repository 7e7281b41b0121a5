"""A layer on which bands are drawn before they are laid over the image."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from sim_hardware.optics.geometry import FloatArray

Image = npt.NDArray[np.float32]


class BandLayer:
    """Collects the coverage and the light of bands, averaged over the instants of an exposure.

    Draw the bands of one instant, which unite; `add` them with the instant's share of the exposure;
    when all instants are in, `lay_over` a image, which empties the layer. `softness_px` is the
    standard deviation of the edges.
    """

    def __init__(self, columns: int, rows: int, softness_px: float) -> None:
        from sim_hardware.optics import kernels

        self._kernels = kernels
        pixels = columns * rows
        self._hidden = np.zeros(pixels, dtype=np.float32)
        self._light = np.zeros(pixels, dtype=np.float32)
        self._layer = kernels.Layer(
            pixels=np.full((pixels, 5), np.inf, dtype=np.float32),
            columns=columns,
            touched=np.zeros(pixels, dtype=np.int32),
            softness=softness_px,
        )
        self._count = 0
        self._changed: list[npt.NDArray[np.int32]] = []

    def draw(self, points_px: FloatArray, half_width_px: FloatArray, level: FloatArray) -> None:
        """Draw a band along raw pixels (n, 2) with half widths (n) and grey levels (n)."""
        band = self._kernels.PixelBand(points_px, half_width_px, level)
        self._count = self._kernels.draw_band(band, self._layer, self._count)

    def add(self, share: float) -> None:
        """Count what was drawn since the last call with this share of the exposure."""
        self._kernels.lay_down(self._layer, self._count, share, self._hidden, self._light)
        self._changed.append(self._layer.touched[: self._count].copy())
        self._count = 0

    def lay_over(self, image: Image) -> None:
        """Lay what was added over a flat image (rows * columns) and empty the layer."""
        for at in self._changed:  # a pixel met again has nothing left to give
            image[at] = image[at] * (1 - self._hidden[at]) + self._light[at]
            self._hidden[at] = 0
            self._light[at] = 0
        self._changed.clear()
