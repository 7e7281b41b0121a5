"""The sense in which the sheet last slid through the rolls."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from model.effects._values import finite
from model.effects.interface import BeamProblem, ContactSolution
from model.measurements import FloatArray, length_scale

TURNED_M, TURNED_RAD = 10e-6, 0.02  # sliding, or leaning, that turns friction round


def slid(beam: BeamProblem, contact: ContactSolution) -> FloatArray:
    """Return which way along the sheet the rolls last slid, 1 towards its end: (K,).

    At 0 V by the side from which the load cell was put to its position. The pulses then move the
    rolls to and fro between where the two polarities hold them; what is too little to turn friction
    round leaves some of what the placing did.
    """
    s, volts = contact.s_hat_m, beam.voltage_V
    turned_m = TURNED_M * length_scale(beam.sheet)
    same = np.abs(beam.stated_m[:, None] - beam.stated_m) < 1e-9
    same &= beam.up[:, None] == beam.up
    at_zero = same & (volts == 0.0)
    placed = beam.up * _turned(np.sin(contact.gamma_rad) / TURNED_RAD)
    first = _either(_mean(placed, at_zero), placed)
    opposite, equal = volts[:, None] * volts < 0.0, volts[:, None] == -volts
    other = _either(_mean(s, same & equal), _mean(s, same & opposite))
    other = _either(other, _mean(s, at_zero))
    begin = _either(_mean(s, at_zero), 0.5 * (s + other))
    far, near = np.fmax(s, other), np.fmin(s, other)
    outward = _bounded(first + (far - begin) / turned_m)
    inward = _bounded(outward - (far - near) / turned_m)
    outward = _bounded(inward + (far - near) / turned_m)
    driven = np.where(s >= other, outward, inward)
    return finite(np.where((volts == 0.0) | np.isnan(other), placed, driven))


def _bounded(way: FloatArray) -> FloatArray:
    return np.clip(way, -1.0, 1.0)


def _either(values: FloatArray, otherwise: FloatArray) -> FloatArray:
    return np.where(np.isnan(values), otherwise, values)


def _mean(values: FloatArray, use: npt.NDArray[np.bool_]) -> FloatArray:
    """Return mean over the columns in use, for each row; NaN: none."""
    use = use & np.isfinite(values)
    count = np.sum(use, axis=1)
    total = np.where(use, finite(values), 0.0).sum(axis=1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _turned(x: FloatArray) -> FloatArray:
    """Return the sign, without a jump."""
    return np.asarray(x / np.sqrt(1.0 + x * x))
