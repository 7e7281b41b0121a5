"""The course of a property along the sheet, relative to its value at the clamp."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
EibmForm = Literal["exp", "cosh", "line", "root"]
StiffnessForm = Literal["sine", "line", "step"]

# A step is a rise over this length: a sheet is no thinner than that.
_STEP_M = 0.5e-3


def fall(s_m: npt.ArrayLike, form: EibmForm, decay_m: float, length_m: float) -> FloatArray:
    """From 1 at the clamp downwards; `decay_m` = 0: it stays 1."""
    s_m = np.asarray(s_m, dtype=float)
    if decay_m <= 0:
        return np.ones_like(s_m)
    if form == "exp":
        return np.exp(-s_m / decay_m)
    if form == "cosh":  # an electrode with nothing beyond its end
        left = np.maximum(0.0, length_m - s_m)
        return np.asarray(np.cosh(left / decay_m) / math.cosh(length_m / decay_m))
    if form == "line":
        return np.maximum(0.0, 1 - s_m / decay_m)
    return 1 / np.sqrt(1 + s_m / decay_m)


def stiffness_rise(s_m: npt.ArrayLike, form: StiffnessForm, length_m: float) -> FloatArray:
    """From 0 at the clamp to 1 at the end of the free length."""
    share = np.asarray(s_m, dtype=float) / length_m
    if form == "sine":
        return np.asarray(np.sin(0.5 * math.pi * share) ** 2)
    if form == "line":
        return share
    return np.asarray(0.5 + 0.5 * np.tanh((share - 0.5) * length_m / _STEP_M))


def broken(
    smooth: Callable[[npt.ArrayLike], FloatArray], s_m: npt.ArrayLike, step_m: float
) -> FloatArray:
    """Straight lines between values of `smooth` so far apart; 0: `smooth` itself."""
    if step_m <= 0:
        return smooth(s_m)
    s_m = np.asarray(s_m, dtype=float)
    nodes = step_m * np.arange(2 + math.ceil(float(np.max(s_m, initial=0.0)) / step_m))
    return np.asarray(np.interp(s_m, nodes, smooth(nodes)))


def bump(s_m: npt.ArrayLike, at_m: float, width_m: float) -> FloatArray:
    """1 at a place, falling to either side as a bell curve with this standard deviation."""
    return np.exp(-0.5 * ((np.asarray(s_m, dtype=float) - at_m) / width_m) ** 2)
