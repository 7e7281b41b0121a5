"""A moving chain by itself, without a world's settings: from rest, under given voltages."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim_hardware.world.chain.chain import Chain, ChainSheet, Equilibrium
from sim_hardware.world.chain.contact import ContactArc, ContactState
from sim_hardware.world.motion import march
from sim_hardware.world.motion.ladder import Ladder
from sim_hardware.world.motion.links import Links, room

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class BareSheet:
    """A chain of n links, its electrodes, and the rolls at a polar angle (None: away)."""

    links: Links
    line: Ladder
    law: march.Law
    step_s: float
    radius_m: float
    polar_rad: float | None
    elongation_m: float = 0.0

    def run(
        self, drive_V: FloatArray, share: FloatArray, stiff: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return force along the arc (m + 1,) in N and angles (m + 1, n + 1), from rest at 0 V on.

        Each entry (m,) belongs to a step: mean voltage, and factors of Me and B at its end. Raises
        ValueError where the sheet is not held throughout.
        """
        state, count = self._at_rest(float(stiff[0])), drive_V.size
        polar, first = self.polar_rad or 0.0, state.row[march.FORCE]
        angles, nothing, even = state.phi[1].copy(), np.zeros(count), np.ones(count)
        rows = np.empty((count, march.COLUMNS))
        phi = np.empty((count, angles.size))
        course = march.Course(
            drive_V=drive_V, share=share, stiff=stiff, axis_rad=polar * even, beside_N=nothing,
            held_N=nothing, roll_x_m=self.radius_m * math.cos(polar) * even,
            roll_y_m=self.radius_m * math.sin(polar) * even, clamp_rad=nothing,
        )  # fmt: skip
        made = march.march(
            self.links, self.line, self.law, omega=500.0, damping=0.1, dt=self.step_s,
            end_m=self._chain.sheet.visible_m, course=course, state=state,
            space=room(angles.size - 1), rows=rows, shapes=phi,
        )  # fmt: skip
        if made < count or (self.polar_rad is not None and not rows[:, march.HELD].all()):
            raise ValueError("the sheet cannot be held there")
        whole = np.vstack((angles, angles, phi))[:-1]  # a row's angles are those a step after it
        return np.concatenate(([first], rows[:, march.FORCE])), whole

    @property
    def _chain(self) -> Chain:
        """The same links at rest."""
        n, h = self.links.spring_Nm.size - 1, self.links.h_m
        hinge_m = (np.arange(n) + 0.5) * h
        rest, soft = self.links.rest_rad[1:] / h, self.links.spring_Nm[1:]
        sheet = ChainSheet(
            free_length_m=n * h,
            elongation_m=self.elongation_m,
            rest_curvature_per_m=lambda s: np.interp(s, hinge_m, rest),
            stiffness=lambda s: np.interp(s, hinge_m, soft / soft[0]),
            load_per_m3=(0.0, self.links.load_N_per_m / (soft[0] * h)),
        )
        return Chain(sheet, h)

    def _at_rest(self, stiff: float) -> march.ChainState:
        found = self._equilibrium()
        n, row, contact = self.links.spring_Nm.size - 1, np.zeros(march.COLUMNS), np.zeros(3)
        phi = np.concatenate(([0.0], found.phi_rad[1 : n + 1]))
        strain = np.concatenate(([0.0], np.diff(phi) - self.links.rest_rad[1:]))
        if found.touched:
            B = self.links.spring_Nm[1] * self.links.h_m * stiff
            contact[:] = found.s_m, B * found.normal_per_m2, found.s_m
            row[[march.S, march.ANGLE, march.HELD]] = found.s_m, found.angle_rad, 1.0
            row[march.FORCE] = B * found.along_per_m2
        return march.ChainState(
            phi=np.array([phi, phi, phi]),
            lag=np.broadcast_to(strain, (2, self.links.share.size, n + 1)).copy(),
            U=np.zeros(n),
            contact=contact,
            row=row,
            outside=np.full(6, np.inf),
            flags=np.zeros(2, dtype=np.int64),
        )

    def _equilibrium(self) -> Equilibrium:
        if self.polar_rad is None:
            return self._chain.free(0.0)
        arc = ContactArc(radius_m=self.radius_m)
        found = ContactState(self._chain, arc).place(0.0, self.polar_rad)
        if found is None:
            raise ValueError("the sheet cannot be held there")
        return found
