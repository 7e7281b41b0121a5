"""How well a model predicts the lengths of the measured curves.

A fit compares curves across themselves alone, since an extracted curve is often as long as the
sheet is stated to be, whatever the scale of the picture is. A camera's scale or perspective changes
their lengths, too. So these tell what a prediction has to do with points along the sheet.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from model.discrepancy.thresholds import WHOLE_CURVE_SHARE
from model.discrepancy.verdict.measured_places import Seen, seen_at
from model.identification.data.data_vector import ConditionData
from model.identification.likelihood.forward_model import ForwardModel
from model.measurements import Curve, FloatArray, rms
from model.sheet.sheet_model import SheetModel


def length_error(model: SheetModel, forward: ForwardModel) -> float:
    """Return the RMS relative error of predicted lengths; NaN where no curve shows the whole sheet.

    At the measured positions; raise `ModelError` where the model predicts nothing there.
    """
    errors = [
        error
        for name, data_vector in zip(forward.names, forward.data_vectors, strict=True)
        for number in sorted({one.session for one in data_vector.seen})
        for error in _errors(
            model.in_session(number), name, [o for o in data_vector.seen if o.session == number]
        )
    ]
    return rms(np.array(errors))


def _errors(model: SheetModel, name: str, some: Sequence[ConditionData]) -> Iterator[float]:
    """Yield those of conditions of one session and configuration."""
    sheet = model.sheet(name).sheet
    ends_m = (sheet.free_length_m, sheet.free_length_m + sheet.elongation_m)
    curves = [
        ((float(one.position_m), float(one.voltage_V)), one.curve, end_m)
        for one in some
        if one.curve is not None and not (one.free or one.zero or one.tilt_rad)
        and (end_m := _shown(one.curve, ends_m)) is not None
    ]  # fmt: skip
    if not curves:
        return
    seen = seen_at(model, name, [place for place, _, _ in curves])
    for (_, curve, end_m), found in zip(curves, seen, strict=True):
        yield _length_m(_points(curve)) / _length_m(_at_shares(found, curve, end_m)) - 1.0


def _shown(curve: Curve, ends_m: Sequence[float]) -> float | None:
    """Return the length that a curve shows: that of the sheet, or with its elongation.

    None where it shows a part. No prediction has a say: each is compared at the same curves.
    """
    end_m = min(ends_m, key=lambda one: abs(one - curve.s_m[-1]))
    return end_m if abs(curve.s_m[-1] / end_m - 1.0) <= WHOLE_CURVE_SHARE else None


def _points(curve: Curve) -> FloatArray:
    return np.stack([curve.x_m, curve.y_m])


def _at_shares(found: Seen, curve: Curve, end_m: float) -> FloatArray:
    """Return points of a prediction up to a length, at the shares at which a curve was measured."""
    s_m = curve.s_m / curve.s_m[-1] * end_m
    return np.stack([np.interp(s_m, found.s_m, places) for places in (found.x_m, found.y_m)])


def _length_m(points_m: FloatArray) -> float:
    """Return the length of the straight lines between points, (2, n)."""
    return float(np.sum(np.hypot(*np.diff(points_m, axis=1))))
