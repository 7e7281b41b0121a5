"""Whether a found curve can be what somebody knows of the strip."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from labrig.errors import LabrigError
from labrig.vision.calibration.optics import Optics
from labrig.vision.curve import FindCurve, NeutralCurve, StripGeometry


def heeding(find: FindCurve) -> FindCurve:
    """Return an extractor that refuses a curve to which a fact objects."""

    def found(
        image: npt.NDArray[Any],
        optics: Optics,
        strip: StripGeometry,
        *,
        start: NeutralCurve | None = None,
    ) -> NeutralCurve:
        curve = find(image, optics, strip, start=start)
        return _heeded(curve, optics) if curve.ok else curve

    return found


def _heeded(curve: NeutralCurve, optics: Optics) -> NeutralCurve:
    for objects in optics.constraints.objections:
        try:
            why = objects(curve.points_px)
        except (Exception, SystemExit) as error:  # noqa: BLE001 - other people's code may raise anything
            # what the user stated decides, so it must not be passed over
            named = "" if isinstance(error, LabrigError) else f"{type(error).__name__}: "
            why = f"{named}{str(error).rstrip('.')}."
        if why:
            return NeutralCurve(ok=False, why=f"check of what is known failed: {why}")
    return curve
