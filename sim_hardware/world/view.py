"""The sheet and the rolls as the camera sees them."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from sim_hardware.world.sheet_states import ObservableStates

FloatArray = npt.NDArray[np.float64]

_SPACING_M = 0.5e-3


def shape_of(states: ObservableStates, k: int) -> FloatArray:
    """Return the curve (n, 2) in m as it lies in the image, from the clamp to the visible end."""
    length_m = states.stage.setup.chain.sheet.visible_m
    s_m = np.linspace(0.0, length_m, 1 + math.ceil(length_m / _SPACING_M))
    return seen_curve(states, k, s_m)


def seen_curve(states: ObservableStates, k: int, s_m: FloatArray) -> FloatArray:
    """Return points (n, 2) of the curve in m as they lie in the image, at these arc lengths."""
    setup = states.stage.setup
    curve = states.curve(k, s_m)
    return setup.settings.view.seen(np.asarray(curve + np.array(setup.scatter.registration_m)))


def contact_of(states: ObservableStates) -> tuple[float, float, float] | None:
    """Return where the rolls are, x and y in m, and which way they look; None: away."""
    setup = states.stage.setup
    if setup.position_m is None:
        return None
    polar_rad, angle_rad = states.rolls_rad(-1)
    place = np.array([setup.registered(polar_rad)])
    x, y = (float(value) for value in setup.settings.view.seen(place)[0])
    return x, y, angle_rad
