"""The sheet and the rolls as the camera sees them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from sim_hardware.world.chain.chain import Equilibrium
from sim_hardware.world.history import Moment
from sim_hardware.world.setup import MountedSheet

FloatArray = npt.NDArray[np.float64]

_SPACING_M = 0.5e-3


def state_of(moment: Moment, k: int = -1) -> Equilibrium:
    """Return the chain at one of the times."""
    setup, drive = moment.stage.setup, float(moment.drive[k])
    out = bool(moment.stage.out(moment.times, moment.drive)[k])
    if setup.position_m is not None and out:
        return setup.free.state(drive)
    state = setup.uncrept.state(drive)
    return _after_creep(setup, state, moment.crept[k]) if setup.crept else state


def _after_creep(setup: MountedSheet, state: Equilibrium, crept: FloatArray) -> Equilibrium:
    """Return the state, its link angles moved by what has crept."""
    phi = state.phi_rad.copy()
    for part, table in zip(crept, setup.crept, strict=True):
        if not table.slipped(np.array([state.drive]))[0]:
            phi += part * (table.state(state.drive).phi_rad - state.phi_rad)
    return replace(state, phi_rad=phi)


def shape_of(moment: Moment, k: int) -> FloatArray:
    """Return the curve (n, 2) in m as it lies in the image, from the clamp to the visible end."""
    setup = moment.stage.setup
    length_m = setup.chain.sheet.visible_m
    s_m = np.linspace(0.0, length_m, 1 + math.ceil(length_m / _SPACING_M))
    curve = setup.chain.curve(state_of(moment, k).phi_rad, s_m)
    return setup.settings.view.seen(np.asarray(curve + np.array(setup.scatter.registration_m)))


def contact_of(moment: Moment) -> tuple[float, float, float] | None:
    """Return where the rolls are, x and y in m, and which way they look; None: away."""
    setup = moment.stage.setup
    if setup.position_m is None:
        return None
    state = state_of(moment)
    place = np.array([setup.registered(setup.arc_rad)])
    x, y = (float(value) for value in setup.settings.view.seen(place)[0])
    return x, y, state.angle_rad if state.touched else setup.arc_rad
