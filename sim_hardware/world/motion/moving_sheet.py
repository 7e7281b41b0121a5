"""One set-up of a moving world: its chain with masses, its electrodes, and how it starts."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from sim_hardware.world.chain.chain import Chain, Equilibrium, nothing
from sim_hardware.world.chain.contact import ContactState
from sim_hardware.world.motion.fluid import immersion
from sim_hardware.world.motion.ladder import Ladder, ladder
from sim_hardware.world.motion.links import Links
from sim_hardware.world.motion.march import (
    ANGLE,
    BACK,
    CELL,
    COLUMNS,
    FORCE,
    HELD,
    SINK,
    ChainState,
    Law,
    S,
)
from sim_hardware.world.setup import MILLI, MountedSheet

FloatArray = npt.NDArray[np.float64]

_FIRST_ROOT = 1.8751040687119612  # of 1 + cos x cosh x: a cantilever's first mode


@dataclass(frozen=True, kw_only=True)
class MovingSheet:
    """What `march` needs to know of a set-up."""

    setup: MountedSheet

    @property
    def cells(self) -> int:
        """Links of the sheet."""
        return self.setup.settings.chain.moving_links

    @property
    def step_s(self) -> float:
        """Of the grid."""
        return self.setup.settings.chain.moving_step_ms * MILLI

    @cached_property
    def chain(self) -> Chain:
        """The same links at rest."""
        sheet = self.setup.chain.sheet
        return Chain(sheet, sheet.free_length_m / self.cells)

    @cached_property
    def hinge_m(self) -> FloatArray:
        """Where along the sheet the hinges are (n,)."""
        return np.asarray((np.arange(self.cells) + 0.5) * self.chain.h_m)

    @property
    def _line_kg_per_m(self) -> float:
        s = self.setup.settings.configurations[self.setup.configuration]
        density = self.setup.settings.mass.density_kg_per_m3
        return density * s.width_mm * s.thickness_mm * MILLI**2

    @cached_property
    def _bar(self) -> tuple[float, float, float]:
        """Mass of elongation and end, and its first and second moment about the sheet's end."""
        mass, length_m = self.setup.settings.mass, self.setup.chain.sheet.elongation_m
        bar_kg = mass.elongation_kg_per_m * length_m
        return (
            bar_kg + mass.end_kg,
            bar_kg * length_m / 2 + mass.end_kg * length_m,
            bar_kg * length_m**2 / 3 + mass.end_kg * length_m**2,
        )

    @property
    def first_omega_rad_per_s(self) -> float:
        """About the first frequency of the free sheet in a vacuum (after Dunkerley)."""
        B, sheet, mu = self.setup.stiffness_Nm2, self.setup.chain.sheet, self._line_kg_per_m
        length_m = sheet.free_length_m
        alone = B / mu * (_FIRST_ROOT / length_m) ** 4
        kg, first, second = self._bar
        about_middle = second + first * length_m + kg * length_m**2 / 3
        barred = B / (length_m * about_middle) if kg else math.inf
        return math.sqrt(1 / (1 / alone + 1 / barred))

    @cached_property
    def links(self) -> Links:
        """The chain with its masses, at rest elastically as `chain`."""
        n, h, setup = self.cells, self.chain.h_m, self.setup
        sheet, s = setup.chain.sheet, setup.settings
        at_m, kg = self._bar_masses()
        width_m = s.configurations[setup.configuration].width_mm * MILLI
        fluid = immersion(s.water.fluid, width_m, self.first_omega_rad_per_s)
        rest = np.asarray(sheet.rest_curvature_per_m(self.hinge_m)) * h
        stiffness = np.broadcast_to(np.asarray(sheet.stiffness(self.hinge_m), dtype=float), (n,))
        return Links(
            h_m=h,
            rest_rad=_after_clamp(rest),
            spring_Nm=_after_clamp(setup.stiffness_Nm2 / h * stiffness),
            mass_kg=_after_clamp(np.full(n, self._line_kg_per_m * h)),
            span_m=_after_clamp(np.full(n, h)),
            bar_at_m=h / 2 + at_m,
            bar_kg=kg,
            bar_span_m=np.full(2, sheet.elongation_m / 2),
            viscous_s=s.loss.viscous_ms * MILLI,
            share=np.array(s.loss.shares, dtype=float),
            relax_s=np.array(s.loss.times_s, dtype=float),
            added_kg_per_m=fluid.added_kg_per_m,
            normal_Ns_per_m2=fluid.normal_Ns_per_m2,
            quadratic_Ns2_per_m3=fluid.quadratic_Ns2_per_m3,
            tangential_Ns_per_m2=0.0,
            load_N_per_m=sheet.load_per_m3[1] * setup.stiffness_Nm2,
        )

    def _bar_masses(self) -> tuple[FloatArray, FloatArray]:
        """Two masses with the elongation's mass and moments, and where beyond the sheet's end."""
        kg, first, second = self._bar
        if kg == 0.0:
            middle = self.setup.chain.sheet.elongation_m / 2
            spread = middle / math.sqrt(3)
        else:
            middle = first / kg
            spread = math.sqrt(max(0.0, second / kg - middle**2))
        return middle + spread * np.array([-1.0, 1.0]), np.full(2, kg / 2)

    @cached_property
    def line(self) -> Ladder:
        """The electrodes."""
        e = self.setup.settings.electrodes
        return ladder(
            self.cells, self.setup.chain.sheet.free_length_m, self.step_s,
            ohm_per_m=e.ohm_per_m, farad_per_m=e.capacitance_F_per_m, bulk_ohm_m=e.bulk_ohm_m,
            leak_S_per_m=e.leak_S_per_m, source_ohm=e.source_ohm,
        )  # fmt: skip

    @cached_property
    def law(self) -> Law:
        """From the double layers' voltage to the moment, in this set-up."""
        setup, s = self.setup, self.setup.settings
        name, B = setup.configuration, setup.stiffness_Nm2
        at_2V = 2.0 * s.electrodes.curvature_per_V_per_m * s.configurations[name].eibm_ratio
        odd = at_2V + s.bumped("eibm", name, self.hinge_m)
        even = s.bumped("even_moment", name, self.hinge_m)
        return Law(
            odd_Nm=_after_clamp(setup.drive_share * B * odd),
            even_Nm=_after_clamp(setup.drive_share**2 * B * even),
            saturation_V=s.eibm.saturation_V,
            negative_ratio=s.eibm.negative_ratio,
        )

    def moment_Nm(self, U: FloatArray, share: float) -> FloatArray:
        """Me at the hinges (n,) with these voltages of the double layers (n,)."""
        part = np.array([self.setup.settings.eibm.settled(float(u)) for u in U])
        return np.asarray(share * part * (self.law.odd_Nm[1:] + part * self.law.even_Nm[1:]))

    def _chain_with(self, U: FloatArray, share: float) -> Chain:
        """Return the chain at rest whose Me is that of the double layers, at drive 1."""
        per_m = self.moment_Nm(U, share) / self.setup.stiffness_Nm2
        sheet = replace(
            self.chain.sheet,
            drive_curvature_per_m=lambda s: np.interp(s, self.hinge_m, per_m),
            even_curvature_per_m=nothing,
        )
        return Chain(sheet, self.chain.h_m)

    def rest(self, U: FloatArray, share: float) -> Equilibrium:
        """Return the chain at rest, led to the rolls at 0 V; free where they cannot hold it."""
        chain = self._chain_with(U, share)
        if self.setup.position_m is None:
            return chain.free(1.0)
        contact, angle_rad = ContactState(chain, self.setup.arc), self.setup.arc_rad
        start = contact.place(0.0, angle_rad)
        if start is None:
            return chain.free(1.0)
        state, whole = contact.drive_to(start, 1.0, angle_rad)
        return state if whole else chain.free(1.0)

    def at_rest(
        self, U: FloatArray, share: float, stiff: float, *, beside_N: float, held_N: float
    ) -> ChainState:
        """Return the state in which nothing moves and all has relaxed.

        A sheet that the rolls cannot hold is free. `stiff`: B over that of a wet sheet;
        `beside_N`: on the load cell beside the sheet's force; `held_N`: while that is held.
        """
        found = self.rest(U, share / stiff)
        phi = np.concatenate(([self.chain.sheet.clamp_rad], found.phi_rad[1 : self.cells + 1]))
        strain = np.concatenate(([0.0], np.diff(phi) - self.links.rest_rad[1:]))
        lag = np.broadcast_to(strain, (2, self.links.share.size, phi.size)).copy()
        row = np.zeros(COLUMNS)
        row[[BACK, SINK]] = self.line.back_S @ U, self.line.sink_S_per_s @ U
        contact = np.zeros(3)
        if found.touched:
            B = self.setup.stiffness_Nm2 * stiff
            contact[:] = found.s_m, B * found.normal_per_m2, found.s_m
            row[[S, ANGLE, HELD]] = found.s_m, found.angle_rad, 1.0
            along = np.array([[found.along_per_m2], [found.outward_per_m2]])
            row[FORCE] = B * float(self.setup.along_axis(along)[0]) + held_N
        row[FORCE] += beside_N
        row[CELL] = row[FORCE]
        return ChainState(
            phi=np.array([phi, phi, phi]),
            lag=lag,
            U=U.copy(),
            contact=contact,
            row=row,
            outside=np.full(6, np.inf),
            flags=np.zeros(2, dtype=np.int64),
        )


def _after_clamp(values: FloatArray) -> FloatArray:
    """With a 0 in front, for the clamp's link."""
    return np.concatenate(([0.0], values))
