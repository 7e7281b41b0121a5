"""A set-up: one sheet in the clamp, the rolls somewhere on the arc or away, with its scatter."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import numpy.typing as npt

from sim_hardware.world.chain.chain import Chain, ChainSheet
from sim_hardware.world.chain.contact import ContactArc, ContactState
from sim_hardware.world.chain.drive_table import DriveTable
from sim_hardware.world.creep import crept_sheets
from sim_hardware.world.settings import WorldSettings

FloatArray = npt.NDArray[np.float64]

_SCATTER_STREAM = 0x5E70
# A set-up is never so odd that stiffness or moment vanish.
_LEAST_SHARE = 0.1
# How far beside a position the rolls take the sheet before they move it there.
_APPROACH_M = 2e-3
MILLI = 1e-3


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """By how much one set-up differs from the nominal one."""

    eibm: float = 1.0
    stiffness: float = 1.0
    position_m: float = 0.0
    tilt_rad: float = 0.0
    registration_m: tuple[float, float] = (0.0, 0.0)

    @staticmethod
    def draw(settings: WorldSettings, number: int) -> Scatter:
        """Return the scatter of the set-up with this number; the same for the same seed."""
        s = settings.scatter
        z = np.random.default_rng((settings.seed, _SCATTER_STREAM, number)).standard_normal(6)
        return Scatter(
            eibm=max(_LEAST_SHARE, 1 + s.eibm * float(z[0])),
            stiffness=max(_LEAST_SHARE, 1 + s.stiffness * float(z[1])),
            position_m=s.position_mm * MILLI * float(z[2]),
            tilt_rad=s.clamp_tilt_rad * float(z[3]),
            registration_m=(
                s.registration_mm * MILLI * float(z[4]),
                s.registration_mm * MILLI * float(z[5]),
            ),
        )


@dataclass(frozen=True, kw_only=True)
class MountedSheet:
    """One set-up; what it does as a function of the drive is worked out when first asked for.

    The drive is the moment relative to the nominal one at +2 V, scatter and drying included, over
    the stiffness likewise.
    """

    settings: WorldSettings
    configuration: str
    position_m: float | None  # as asked for; None: nothing touches the sheet
    scatter: Scatter
    turned_over: bool = False  # the whole rig, about the sheet's long axis

    @property
    def stiffness_Nm2(self) -> float:
        """B of a wet sheet in this set-up."""
        return (
            self.settings.configurations[self.configuration].stiffness_Nm2 * self.scatter.stiffness
        )

    @property
    def drive_share(self) -> float:
        """Drive of this set-up over the nominal one."""
        return self.scatter.eibm / self.scatter.stiffness

    @property
    def arc_rad(self) -> float:
        """Polar angle at which the rolls really are."""
        if self.position_m is None:
            raise ValueError("nothing touches the sheet")
        at_m = self.settings.arc.reached_m(self.position_m) + self.scatter.position_m
        return self.arc.angle_rad(at_m)

    def registered(self, polar_rad: float) -> tuple[float, float]:
        """Return a point of the arc as the camera sees it: its zero is not quite the clamp."""
        radius_m, (dx, dy) = self.arc.radius_m, self.scatter.registration_m
        return radius_m * math.cos(polar_rad) + dx, radius_m * math.sin(polar_rad) + dy

    @cached_property
    def arc(self) -> ContactArc:
        """The arc, and how the rolls touch."""
        s = self.settings
        give = s.load_cell.compliance_mm_per_mN * self.stiffness_Nm2  # m per force over B
        return ContactArc(
            radius_m=s.arc.radius_mm * MILLI,
            origin_rad=math.radians(s.arc.origin_deg),
            roll_offset_m=s.rolls.offset_mm * MILLI,
            give_rad_m2=give / (s.arc.radius_mm * MILLI),
        )

    @cached_property
    def chain(self) -> Chain:
        """The sheet's chain of links."""
        s = self.settings
        sheet = s.configurations[self.configuration]
        B = self.stiffness_Nm2
        return Chain(
            ChainSheet(
                free_length_m=sheet.free_length_m,
                elongation_m=sheet.elongation_m,
                rest_curvature_per_m=self._rest_curvature,
                drive_curvature_per_m=partial(s.eibm_per_m, self.configuration),
                even_curvature_per_m=partial(s.bumped, "even_moment", self.configuration),
                stiffness=self._stiffness,
                stiffening=sheet.stiffening,
                knee_per_m=sheet.stiffening_knee_per_m,
                elongation_stiffness=1 / max(sheet.elongation_give, 1e-12),
                joint_m=sheet.elongation_joint_mm * MILLI,
                clamp_rad=s.clamp.tilt_rad + self.scatter.tilt_rad,
                # mrad/(N mm) = rad/(N m)
                clamp_compliance_m=s.clamp.compliance_mrad_per_Nmm * B,
                load_per_m3=(0.0, (1 if self.turned_over else -1) * s.gravity_N_per_m / B),
            ),
            s.chain.link_mm * MILLI,
        )

    def _rest_curvature(self, s_m: FloatArray) -> FloatArray:
        sheet = self.settings.configurations[self.configuration]
        more = self.settings.bumped("rest_curvature", self.configuration, s_m)
        return sheet.rest_curvature(s_m) + more

    def _stiffness(self, s_m: FloatArray) -> FloatArray:
        sheet = self.settings.configurations[self.configuration]
        return sheet.relative_stiffness(s_m) + self.settings.bumped(
            "stiffness", self.configuration, s_m
        )

    @cached_property
    def free(self) -> DriveTable:
        """The sheet with nothing touching it."""
        return DriveTable(ContactState(self.chain, self.arc), None)

    @cached_property
    def held(self) -> DriveTable:
        """The sheet between the rolls."""
        return DriveTable(ContactState(self.chain, self.arc), self.arc_rad)

    @cached_property
    def uncrept(self) -> DriveTable:
        """The sheet as it lies when nothing has crept, between the rolls or free."""
        return self.free if self.position_m is None else self.held

    @cached_property
    def crept(self) -> tuple[DriveTable, ...]:
        """The sheet after each part of its strain has stayed for ever; see `creep`."""
        share = self.settings.creep.share
        if share == 0.0 or not self.uncrept.reachable:
            return ()
        angle_rad = None if self.position_m is None else self.arc_rad
        sheets = crept_sheets(self.chain, self.uncrept, share)
        chains = [Chain(sheet, self.settings.chain.link_mm * MILLI) for sheet in sheets]
        return tuple(DriveTable(ContactState(chain, self.arc), angle_rad) for chain in chains)

    @cached_property
    def _rubbed(self) -> tuple[DriveTable, DriveTable]:
        """The sheet between rolls that rub with all their friction, either way."""
        mu = self.settings.rolls.friction
        arcs = [replace(self.arc, friction=sign * mu) for sign in (1.0, -1.0)]
        up, down = (DriveTable(ContactState(self.chain, arc), self.arc_rad) for arc in arcs)
        return up, down

    def slipped(self, drive: FloatArray) -> npt.NDArray[np.bool_]:
        """Return where along these drives the sheet is out of the rolls."""
        if self.position_m is None:
            return np.zeros(drive.shape, dtype=bool)
        return self.held.slipped(drive)

    def cell_force_per_m2(self, drive: FloatArray) -> FloatArray:
        """Force along the load cell's axis over B, without friction; the sheet must be held."""
        return self.along_axis(self.held.forces_per_m2(drive))

    def crept_force_per_m2(self, drive: FloatArray, strain: FloatArray) -> FloatArray:
        """Return the part of creep in that force, with parts `strain` (n, 3) of the strain."""
        before = self.held.forces_per_m2(drive)
        change = np.zeros_like(before)
        for part, table in zip(strain.T, self.crept, strict=True):
            lost = table.slipped(drive)
            change[:, ~lost] += part[~lost] * (table.forces_per_m2(drive[~lost]) - before[:, ~lost])
        return self.along_axis(change)

    def along_axis(self, forces: FloatArray) -> FloatArray:
        """Component along the load cell's axis of forces (2, n): along the arc and outward."""
        off = math.radians(self.settings.load_cell.misalignment_deg)
        return np.asarray(forces[0] * math.cos(off) - forces[1] * math.sin(off))

    @cached_property
    def rubs(self) -> bool:
        """Whether friction plays a part."""
        return self.settings.rolls.friction > 0 and self.position_m is not None

    def friction_per_m2(self, drive: FloatArray) -> FloatArray:
        """Return the change of force over B when the rolls have slid outward along the sheet."""
        up, down = self._rubbed
        lost = up.slipped(drive) | down.slipped(drive)
        result = np.zeros_like(drive)
        held = drive[~lost]
        change = self.along_axis(up.forces_per_m2(held) - down.forces_per_m2(held)) / 2
        result[~lost] = change * np.sign(self.held.contact(held)[0])
        return result

    def sliding_m(self, drive: FloatArray) -> FloatArray:
        """Return where along the sheet the rolls are."""
        return np.asarray(self.held.contact(drive)[1])

    def arriving_N(self, *, moved_up: bool) -> FloatArray:
        """Return forces at 0 V on the way here: untouched, a little away, here, if held."""
        if self.position_m is None or not self.held.reachable:
            return np.zeros(1)
        beside_rad = self.arc_rad + (-1 if moved_up else 1) * _APPROACH_M / self.arc.radius_m
        contact = ContactState(self.chain, self.arc)
        states = [contact.place(0.0, beside_rad), self.held.state(0.0)]
        forces = [(s.along_per_m2, s.outward_per_m2) for s in states if s is not None]
        felt = self.stiffness_Nm2 * self.along_axis(np.array(forces).T)
        return np.concatenate(([0.0], felt))

    def first_slide(self, *, moved_up: bool) -> float:
        """Return the direction in which the rolls slid along the sheet on the way: 1 outward."""
        if self.position_m is None or not self.held.reachable:
            return 0.0
        outward = math.sin(self.held.state(0.0).angle_rad - self.arc_rad)
        return math.copysign(1.0, outward if moved_up else -outward)
