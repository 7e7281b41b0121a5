"""What a band leaves unexplained of the pixels beside a curve, piece by piece."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.vision.fit.context import CrossSection, measured
from labrig.vision.fit.side_face.pixels import PixelsBeside

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

PIECE_CELLS = 24
LINEAR_RANGE_PX = 0.25  # so far a displacement, or another blur, has the effect of its derivative
SWING_BLUR_MAX_PX = 0.4  # that a swing adds at the tip; more is no band any more


class BandResiduals:
    """The residuals of bands on the cells that are used, over the noise."""

    def __init__(self, used: BoolArray, noise: float) -> None:
        self.used, self.noise, self.swing = used, noise, _swing(len(used))

    def squares(
        self,
        seen: PixelsBeside,
        section: CrossSection,
        *,
        tuned: bool = False,
        swinging: bool = False,
    ) -> FloatArray:
        """Return (pieces,) squared residuals over the noise's, each piece displaced a little.

        `tuned`: also with the blur, and an elongation's width, that suit the band best;
        `swinging`: and with a blur that grows towards the tip, as in the mean image of a sheet
        that swings. That looks wider at the tip on both sides, a face on one.
        """
        # weights that forgive little would count a missing face as an outlier
        cells = measured(seen.pixels_for(section), section, 3 * self.noise, self.used)
        cells = np.where(self.used[:, None], cells, 0.0)
        pieces = np.arange(0, len(cells), PIECE_CELLS)
        information, pull, left = (
            np.add.reduceat(cells[:, column], pieces) for column in (3, 4, 5)
        )
        left = left - _gained(pull, information, _step(pull, information))
        if tuned:
            gained = np.zeros(len(cells))
            for part in (section.elongation, ~section.elongation):
                steeper, sharpness = cells[part, 7], cells[part, 8]
                step = _step(steeper.sum(), sharpness.sum())
                gained[part] = _gained(steeper, sharpness, step)
                if swinging:
                    step = _growing(steeper, sharpness, self.swing[part])
                    also = _gained(steeper, sharpness, step)
                    gained[part] = also if also.sum() > gained[part].sum() else gained[part]
            left = left - np.add.reduceat(gained, pieces)
        return np.asarray(np.maximum(left, 0.0) / self.noise**2)


def _step(pull: Any, information: Any) -> FloatArray:
    """Return the best small step along a derivative."""
    return np.asarray(
        np.clip(pull / np.maximum(information, 1e-9), -LINEAR_RANGE_PX, LINEAR_RANGE_PX)
    )


def _growing(steeper: FloatArray, sharpness: FloatArray, swing: FloatArray) -> FloatArray:
    """Return (cells,) the best small step that is the same everywhere, and one that grows."""
    both = np.array([np.ones_like(swing), swing])
    normal = (both * sharpness) @ both.T + 1e-9 * np.eye(2)
    same, more = np.linalg.solve(normal, both @ steeper)
    if more <= 0:
        return np.zeros_like(swing)
    same, more = np.clip([same, more], -LINEAR_RANGE_PX, [LINEAR_RANGE_PX, SWING_BLUR_MAX_PX])
    return np.asarray(same + more * swing)


def _swing(cells: int) -> FloatArray:
    """Return (cells,) how much a swing in the first mode blurs the mean image, against the tip."""
    along = np.arange(cells) / max(cells - 1, 1)
    return np.asarray((along**2 * (6 - 4 * along + along**2) / 3) ** 2)


def _gained(pull: FloatArray, information: FloatArray, step: FloatArray) -> FloatArray:
    """Return what squared residuals lose by a small step."""
    return np.asarray(2 * step * pull - step**2 * information)
