"""The sheet as a chain of many rigid links with elastic hinges, at rest at its least energy.

Nothing here is shared with `model`: other unknowns, other numerics, other code. The positions are
good to O(h^2) of the link length h.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from sim_hardware.world.chain.kernels import Hinges

FloatArray = npt.NDArray[np.float64]
AlongSheet = Callable[[FloatArray], npt.ArrayLike]

# A hinge that does not give: the clamp's, and those of the elongation. Turns by 1e-9 of a link's.
RIGID = 1e9
# Links beyond the end, so that the rounding of the last ones has something to round with.
_BEYOND = 3


def nothing(s_m: FloatArray) -> FloatArray:
    """0 everywhere along the sheet."""
    return np.zeros_like(s_m)


def even(s_m: FloatArray) -> FloatArray:
    """1 everywhere along the sheet."""
    return np.ones_like(s_m)


@dataclass(frozen=True, kw_only=True)
class ChainSheet:
    """A sheet, per unit of its bending stiffness B. Functions take s (m) as an array.

    This is where a further property of the sheet or of its clamp goes; `Chain` lays it on hinges.
    """

    free_length_m: float
    elongation_m: float = 0.0
    rest_curvature_per_m: AlongSheet = nothing  # k0
    drive_curvature_per_m: AlongSheet = nothing  # Me/B at unit drive
    even_curvature_per_m: AlongSheet = nothing  # what Me/B has that goes with the drive's square
    stiffness: AlongSheet = even  # relative to B
    stiffening: float = 0.0  # relative gain of stiffness at large changes of curvature
    knee_per_m: float = 30.0  # change of curvature with half of that gain
    clamp_rad: float = 0.0  # direction in which the clamp holds it
    clamp_compliance_m: float = 0.0  # turn of the clamped end per moment over B
    elongation_stiffness: float = math.inf  # relative to B
    joint_m: float = 0.0  # the joint to the elongation gives way like so much of the sheet
    load_per_m3: tuple[float, float] = (0.0, 0.0)  # weight per length over B, along x and y

    @property
    def visible_m(self) -> float:
        """Length of sheet and elongation together."""
        return self.free_length_m + self.elongation_m


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """The chain at rest. Forces are those on the object, over B, in 1/m^2."""

    drive: float
    phi_rad: FloatArray  # (links,)
    s_m: float  # where the object touches; nan: nowhere
    angle_rad: float  # direction of the sheet there
    normal_per_m2: float  # N/B
    along_per_m2: float  # along the tangent of the arc: F/B
    outward_per_m2: float  # away from the clamp

    @property
    def touched(self) -> bool:
        """Whether anything touches the sheet."""
        return math.isfinite(self.s_m)


class Chain:
    """A sheet cut into links of about `link_m` each; the free length is a whole number of them."""

    def __init__(self, sheet: ChainSheet, link_m: float) -> None:
        self.sheet = sheet
        cut = max(1, math.ceil(sheet.free_length_m / link_m - 1e-9))
        self.h_m = sheet.free_length_m / cut
        self.links = 1 + math.ceil(sheet.visible_m / self.h_m - 1e-9) + _BEYOND
        self.hinge_m = np.linspace(-0.5, self.links - 1.5, self.links) * self.h_m
        self.hinge_m[0] = 0.0
        self._on_sheet = (np.arange(self.links) >= 1) & (np.arange(self.links) <= cut)

    def hinges(self, drive: float) -> Hinges:
        """Return the kernels' `Hinges` at this drive."""
        from sim_hardware.world.chain.kernels import Hinges

        sheet = self.sheet
        load = np.outer(sheet.load_per_m3, np.maximum(0.0, sheet.visible_m - self._link_centre_m))
        return Hinges(
            h_m=self.h_m,
            rest_per_m=self._rest,
            drive_per_m=drive * self._drive + drive * drive * self._even,
            stiffness=self._stiffness,
            stiffening=sheet.stiffening,
            knee_per_m=sheet.knee_per_m,
            clamp_rad=sheet.clamp_rad,
            load_x_per_m2=load[0],
            load_y_per_m2=load[1],
        )

    @cached_property
    def _link_centre_m(self) -> FloatArray:
        centre = np.linspace(0.0, self.links - 1.0, self.links) * self.h_m
        centre[0] = self.h_m / 4
        return centre

    def _laid_on(self, function: AlongSheet, elsewhere: float) -> FloatArray:
        """Values at the hinges of the sheet."""
        values = np.full(self.links, elsewhere)
        values[self._on_sheet] = np.broadcast_to(
            np.asarray(function(self.hinge_m[self._on_sheet]), dtype=float), self._on_sheet.sum()
        )
        return values

    @cached_property
    def _rest(self) -> FloatArray:
        return self._laid_on(self.sheet.rest_curvature_per_m, 0.0)

    @cached_property
    def _drive(self) -> FloatArray:
        return self._laid_on(self.sheet.drive_curvature_per_m, 0.0)

    @cached_property
    def _even(self) -> FloatArray:
        return self._laid_on(self.sheet.even_curvature_per_m, 0.0)

    @cached_property
    def _stiffness(self) -> FloatArray:
        sheet = self.sheet
        values = self._laid_on(sheet.stiffness, min(RIGID, sheet.elongation_stiffness))
        values[0] = min(RIGID, self.h_m / max(sheet.clamp_compliance_m, 1e-300))
        joint = int(np.count_nonzero(self._on_sheet)) + 1
        give_m = self.h_m / values[joint] + sheet.joint_m
        values[joint] = min(RIGID, self.h_m / give_m)
        return values

    def free(self, drive: float) -> Equilibrium:
        """Return the chain with nothing touching it."""
        from sim_hardware.world.chain import kernels

        phi = np.full(self.links, self.sheet.clamp_rad)
        status = kernels.relax_free(phi, self.hinges(drive))
        if status != kernels.SOLVED:
            raise ArithmeticError("the chain found no rest: its load is beyond what it stands")
        return Equilibrium(
            drive=drive,
            phi_rad=phi,
            s_m=math.nan,
            angle_rad=math.nan,
            normal_per_m2=0.0,
            along_per_m2=0.0,
            outward_per_m2=0.0,
        )

    def corners(self, phi_rad: FloatArray) -> FloatArray:
        """Points (links + 1, 2): the clamp, then the far end of each link, in m."""
        length = np.full(self.links, self.h_m)
        length[0] /= 2
        steps = length[:, None] * np.column_stack((np.cos(phi_rad), np.sin(phi_rad)))
        return np.concatenate((np.zeros((1, 2)), np.cumsum(steps, axis=0)))

    def curve(self, phi_rad: FloatArray, s_m: FloatArray) -> FloatArray:
        """Points (n, 2) on the chain at the arc lengths `s_m`, in m."""
        corners = self.corners(phi_rad)
        at = np.concatenate(([0.0], (np.arange(self.links) + 0.5) * self.h_m))
        return np.column_stack([np.interp(s_m, at, corners[:, k]) for k in (0, 1)])

    def energy_per_m(self, state: Equilibrium) -> float:
        """Elastic energy over B of a chain without stiffening, the drive's work taken off."""
        before = np.concatenate(([self.sheet.clamp_rad], state.phi_rad[:-1]))
        curvature = (state.phi_rad - before) / self.h_m
        change = curvature - self._rest
        stored = 0.5 * self._stiffness * change**2 - state.drive * self._drive * curvature
        return float(np.sum(stored) * self.h_m)
