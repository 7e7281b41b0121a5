"""The built-in extractor: a curve fitted to the intensities of all pixels beside it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy.typing as npt

from labrig.vision import NeutralCurve, Optics, StripGeometry, neutral_curve


@dataclass(frozen=True)
class IntensityFit:
    """`labrig.vision.neutral_curve` as an extractor."""

    summary: str = (
        "Search the image for the sheet's path and fit a smooth curve to the grey values beside it."
    )

    def curve(
        self,
        image: npt.NDArray[Any],
        optics: Optics,
        strip: StripGeometry,
        *,
        start: NeutralCurve | None = None,
    ) -> NeutralCurve:
        """Return the neutral curve; see `labrig.vision.neutral_curve`."""
        return neutral_curve(image, optics, strip, start=start)


EXTRACTOR = IntensityFit()
