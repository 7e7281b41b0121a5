"""The sheet at some times: what of it the load cell feels and the camera sees."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import numpy.typing as npt

from sim_hardware.world.chain.chain import Equilibrium
from sim_hardware.world.mechanics import Stage

FloatArray = npt.NDArray[np.float64]


class ObservableStates(Protocol):
    """Some times within one set-up, of a sheet at rest as of one that moves."""

    @property
    def stage(self) -> Stage:
        """The set-up."""

    @property
    def times(self) -> FloatArray:
        """(n,)."""

    @property
    def true_N(self) -> FloatArray:
        """Force along the load cell's axis (n,)."""

    @property
    def felt_N(self) -> FloatArray:
        """What the load cell shows of it, without noise (n,)."""

    def curve(self, k: int, s_m: FloatArray) -> FloatArray:
        """Return points (m, 2) of the sheet at one of the times, at these arc lengths, in m."""

    def rolls_rad(self, k: int) -> tuple[float, float]:
        """Return where on the arc the rolls are at one of the times, and the sheet's direction.

        The load cell must not be away.
        """


@dataclass(frozen=True, kw_only=True)
class SheetStates:
    """The sheet's state at some times, at rest at each of them."""

    stage: Stage
    times: FloatArray
    states: FloatArray  # (n, columns), see state_kernels
    drive: FloatArray
    true_N: FloatArray  # along the load cell's axis
    felt_N: FloatArray  # by the load cell, without noise
    crept: FloatArray  # (n, 3), see creep

    def curve(self, k: int, s_m: FloatArray) -> FloatArray:
        """See `ObservableStates.curve`."""
        return self.stage.setup.chain.curve(self._state(k).phi_rad, s_m)

    def rolls_rad(self, k: int) -> tuple[float, float]:
        """See `ObservableStates.rolls_rad`."""
        state, polar_rad = self._state(k), self.stage.setup.arc_rad
        return polar_rad, state.angle_rad if state.touched else polar_rad

    def _state(self, k: int) -> Equilibrium:
        """Return the chain at one of the times."""
        setup, drive = self.stage.setup, float(self.drive[k])
        out = bool(self.stage.out(self.times, self.drive)[k])
        if setup.position_m is not None and out:
            return setup.free.state(drive)
        state = setup.uncrept.state(drive)
        return self._after_creep(state, self.crept[k]) if setup.crept else state

    def _after_creep(self, state: Equilibrium, crept: FloatArray) -> Equilibrium:
        """Return the state, its link angles moved by what has crept."""
        phi = state.phi_rad.copy()
        for part, table in zip(crept, self.stage.setup.crept, strict=True):
            if not table.slipped(np.array([state.drive]))[0]:
                phi += part * (table.state(state.drive).phi_rad - state.phi_rad)
        return replace(state, phi_rad=phi)
