"""A moving sheet at some times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim_hardware.world.chain.chain import Chain
from sim_hardware.world.mechanics import Stage

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class MovingSheetStates:
    """See `sheet_states.ObservableStates`."""

    stage: Stage
    times: FloatArray
    chain: Chain
    phi_rad: FloatArray  # (n, links + 1), the clamp's first
    true_N: FloatArray
    felt_N: FloatArray
    polar_rad: FloatArray  # (n,) where on the arc the rolls are
    angle_rad: FloatArray  # (n,) direction of the sheet there

    def curve(self, k: int, s_m: FloatArray) -> FloatArray:
        """See `ObservableStates.curve`."""
        phi = self.phi_rad[k]
        beyond = np.full(self.chain.links - phi.size, phi[-1])
        return self.chain.curve(np.concatenate((phi, beyond)), s_m)

    def rolls_rad(self, k: int) -> tuple[float, float]:
        """See `ObservableStates.rolls_rad`."""
        return float(self.polar_rad[k]), float(self.angle_rad[k])
