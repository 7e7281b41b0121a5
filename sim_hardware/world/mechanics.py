"""From the sheet's inner state to the force on the load cell, one set-up after the other."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from sim_hardware.world.setup import MountedSheet

FloatArray = npt.NDArray[np.float64]

# Drying stiffens the sheet by no more than this factor, and takes no more than this of its moment.
_MOST_STIFFENING = 2.2
_MOST_WEAKENING = 0.8
# The rolls slide this far along the sheet before friction has turned round.
SLIDE_M = 20e-6

# The elements that lag behind: the load cell's hysteresis, sticking rolls, friction.
ELEMENTS = 3


@dataclass
class Slip:
    """The time at which the sheet slipped out of the rolls; it does not return by itself."""

    since_s: float = math.inf


@dataclass(frozen=True, kw_only=True)
class Stage:
    """A set-up from a moment on, with what hangs on the load cell."""

    start_s: float
    setup: MountedSheet
    load_N: float = 0.0
    moved_up: bool = True
    slip: Slip = field(default_factory=Slip)

    def drive(self, states: FloatArray) -> FloatArray:
        """Return the drive of the set-up's chain in states (n, columns); see state_kernels."""
        moment = states[:, 1] - self.setup.settings.eibm.relaxation * states[:, 4]
        share = self.setup.drive_share * moment * self.moment_share(states)
        return np.asarray(share / self.stiffening(states[:, 3]))

    def moment_share(self, states: FloatArray) -> FloatArray:
        """Return what water, drying and tiring leave of the moment."""
        from sim_hardware.world.signals.kernels import approach, waves

        _, _, uneven, dry_s, _, _, _, _, driven_s = states.T
        water, eibm = self.setup.settings.water, self.setup.settings.eibm
        share = 1 - water.first_pulse_deficit * uneven
        weakening = water.weakening_per_min / 60
        share *= 1 - approach(self._drying_s(dry_s), _MOST_WEAKENING, weakening)
        if water.tiring_per_min:
            share *= 1 - approach(driven_s, _MOST_WEAKENING, water.tiring_per_min / 60)
        if eibm.breathing:
            omega = np.array([2 * math.pi / eibm.breathing_s])
            share *= 1 + eibm.breathing * waves(driven_s, omega, np.zeros(1))
        return np.asarray(share)

    def stiffening(self, dry_s: FloatArray) -> FloatArray:
        """B over that of a wet sheet."""
        from sim_hardware.world.signals.kernels import approach

        rate = self.setup.settings.water.stiffening_per_min / 60
        return np.asarray(1 + approach(self._drying_s(dry_s), _MOST_STIFFENING - 1, rate))

    def _drying_s(self, dry_s: FloatArray) -> FloatArray:
        """Time under voltage as what dries counts it: all forms agree after a minute."""
        from sim_hardware.world.signals.kernels import approach

        water = self.setup.settings.water
        if water.drying_form == "root":
            return np.sqrt(60.0 * dry_s)
        if water.drying_form == "exp":
            most_s = -60.0 / math.expm1(-60.0 / water.drying_s)
            return approach(dry_s, most_s, most_s / water.drying_s)
        return dry_s

    def out(self, times: FloatArray, drive: FloatArray) -> npt.NDArray[np.bool_]:
        """Return where the sheet is out of the rolls, though they are there."""
        return (times >= self.slip.since_s) | self.setup.slipped(drive)

    def moved(
        self, times: FloatArray, drive: FloatArray, dry_s: FloatArray, crept: FloatArray
    ) -> FloatArray:
        """Force along the load cell's axis in N, and place along the sheet in m: (n, 2).

        Without what lags behind, but for creep: `crept` (n, 3), see `creep`. Once out of the rolls:
        only what hangs on the cell.
        """
        result = np.zeros((times.size, 2))
        if self.setup.position_m is not None:
            held = ~self.out(times, drive)
            B = self.setup.stiffness_Nm2 * self.stiffening(dry_s[held])
            force_N = B * self.setup.cell_force_per_m2(drive[held])
            if self.setup.crept:
                force_N = force_N + B * self.setup.crept_force_per_m2(drive[held], crept[held])
            result[held, 0] = force_N + self.meniscus_N(dry_s[held])
            if self.setup.rubs:
                result[held, 1] = self.setup.sliding_m(drive[held])
        result[:, 0] += self.load_N
        return result

    def meniscus_N(self, dry_s: FloatArray) -> FloatArray:
        """Force of the water between sheet and rolls, while they hold it."""
        from sim_hardware.world.signals.kernels import approach

        rolls = self.setup.settings.rolls
        share = self.setup.settings.configurations[self.setup.configuration].meniscus_share
        left = np.full(dry_s.shape, rolls.meniscus_mN * 1e-3 * share)
        if rolls.meniscus_dries_s:
            left *= 1 - approach(dry_s, 1.0, 1 / rolls.meniscus_dries_s)
        return left

    def watch(self, times: FloatArray, drive: FloatArray) -> None:
        """Remember when, along these times, the sheet slipped out."""
        out = self.setup.slipped(drive)
        if out.any():
            self.slip.since_s = min(self.slip.since_s, float(times[np.argmax(out)]))

    def friction_N(
        self, times: FloatArray, drive: FloatArray, dry_s: FloatArray, turned_m: FloatArray
    ) -> FloatArray:
        """Return the force of friction in the rolls, with its element `turned_m` so far."""
        result = np.zeros(times.size)
        if not self.setup.rubs:
            return result
        held = ~self.out(times, drive)
        B = self.setup.stiffness_Nm2 * self.stiffening(dry_s[held])
        result[held] = B * self.setup.friction_per_m2(drive[held]) * turned_m[held] / SLIDE_M
        return result

    def first_turned(self, reach: FloatArray) -> FloatArray:
        """Return the elements of a new set-up, which turn by no more than `reach` (ELEMENTS,)."""
        first = np.zeros(ELEMENTS)
        for step_N in np.diff(self.setup.arriving_N(moved_up=self.moved_up)):
            first[:2] = np.clip(first[:2] + step_N, -reach[:2], reach[:2])
        if self.setup.rubs:
            first[2] = SLIDE_M * self.setup.first_slide(moved_up=self.moved_up)
        return first

    @property
    def sticking_N(self) -> float:
        """Force below which a change does not come through the rolls."""
        rolls, at_m = self.setup.settings.rolls, self.setup.position_m
        sticks = at_m is not None and at_m >= rolls.stick_from_mm * 1e-3 - 1e-9
        return rolls.stick_mN * 1e-3 if sticks else 0.0
