"""`neutral_curve`: one image in, the sheet's curve with its uncertainty out, or a reason."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve import NeutralCurve, StripGeometry
from labrig.vision.extraction.extract import unconfirmed_curve
from labrig.vision.salience.second_look import changed_by_it, seen_again


def neutral_curve(
    image: npt.NDArray[Any],
    optics: Optics,
    strip: StripGeometry,
    *,
    start: NeutralCurve | None = None,
) -> NeutralCurve:
    """Return the neutral curve of the sheet in `image` (rows, columns), 8 or 16 bit grey.

    `start`: the curve of an image shortly before; it is followed, which is several times faster,
    and given up for a search from the clamp where its curve fails the self-check. Where neither
    length, tip nor places are stated, a second look at what stands out in the picture may lead the
    curve on, cut it or replace it; a curve that is followed is looked at again only where the one
    before had been changed by that. What cannot be measured comes back with `ok` False and the
    reason, never raised.
    """
    found = unconfirmed_curve(image, optics, strip, start=start)
    if found.ok and start is not None and start.ok and not changed_by_it(start):
        return found.confirmed()
    return seen_again(found, image, optics, strip).confirmed()
