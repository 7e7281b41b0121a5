"""Masks: polygons of an image whose pixels are not used."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics

MaskArray = npt.NDArray[np.uint8]
SUBPIXEL_BITS = 4


def polygon_mask(optics: Optics, shape: tuple[int, int], margin_px: float = 0.0) -> MaskArray:
    """Return (rows, columns) what is 1 inside of the polygons, or as near to them as the margin."""
    import cv2

    mask = np.zeros(shape, np.uint8)
    for polygon in optics.mask_px or ():
        corners = np.round(np.array(polygon) * 2**SUBPIXEL_BITS).astype(np.int32)
        cv2.fillPoly(mask, [corners], 1, cv2.LINE_8, SUBPIXEL_BITS)
        if margin_px > 0:
            thick = max(1, round(2 * margin_px))
            cv2.polylines(
                mask, [corners], isClosed=True, color=1, thickness=thick, shift=SUBPIXEL_BITS
            )
    return mask
