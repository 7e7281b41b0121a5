"""Follow a sheet from frame to frame; search again where it was lost."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve import FindCurve, NeutralCurve, StripGeometry
from labrig.vision.extraction.extract import neutral_curve
from model.measurements.known_arguments import known_arguments


@known_arguments
class Tracker:
    """Follows one sheet through the images of one camera."""

    def __init__(
        self, optics: Optics, strip: StripGeometry, find: FindCurve = neutral_curve
    ) -> None:
        self.find = find
        self.optics = optics
        self.strip = strip
        self.last: NeutralCurve | None = None

    def curve(self, image: npt.NDArray[Any]) -> NeutralCurve:
        """Return the curve in the next image. An image without one does not end the tracking."""
        return self.taken(self.find(image, self.optics, self.strip, start=self.last))

    def taken(self, found: NeutralCurve) -> NeutralCurve:
        """Return the curve of the next image, which is known, and follow it."""
        if found.ok:
            self.last = found
        return found

    def curves(self, images: Iterable[npt.NDArray[Any]]) -> Iterator[NeutralCurve]:
        """Return the curve in each image."""
        for image in images:
            yield self.curve(image)

    def lost(self) -> None:
        """Forget the last curve, as after a change of the set-up."""
        self.last = None
