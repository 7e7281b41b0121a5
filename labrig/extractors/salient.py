"""The built-in curve, with a second look at what stands out in the picture.

For photographs of which little is stated. It needs the weights of a small network, which are no
part of labrig.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy.typing as npt

from labrig.vision import NeutralCurve, Optics, StripGeometry


@dataclass(frozen=True)
class Salient:
    """`labrig.vision.neutral_curve`, led on or replaced by what stands out."""

    summary: str = (
        "As intensity_fit; where neither length nor tip is stated, a network's second look at what "
        "stands out in the picture leads the curve on, or replaces it."
    )

    def curve(
        self,
        image: npt.NDArray[Any],
        optics: Optics,
        strip: StripGeometry,
        *,
        start: NeutralCurve | None = None,
    ) -> NeutralCurve:
        """Return the neutral curve; see `labrig.vision.salience.second_look`."""
        from labrig.vision.extraction.extract import unconfirmed_curve
        from labrig.vision.salience.second_look import seen_again

        first = unconfirmed_curve(image, optics, strip, start=start)
        return seen_again(first, image, optics, strip).confirmed()


EXTRACTOR = Salient()
