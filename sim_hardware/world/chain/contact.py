"""The chain held by an object on the arc: found by following it there from the free shape."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from sim_hardware.world.chain.chain import Chain, Equilibrium, FloatArray

# Where the path is lost between two points so close together, the sheet has slipped out.
_SHORTEST_STEP_RAD = 1e-4
_SHORTEST_DRIVE = 1e-4
_LONGEST_STEP_RAD = 0.25
# A load cell gives way by far less than the sheet: each round gains a digit or more.
_GIVE_ROUNDS = 10
_LONGEST_DRIVE = 0.3


@dataclass(frozen=True, kw_only=True)
class ContactArc:
    """The arc about the clamp on which the object moves, and its contact with the sheet."""

    radius_m: float
    origin_rad: float = 0.0
    roll_offset_m: float = 0.0
    friction: float = 0.0  # signed
    give_rad_m2: float = 0.0  # how far the object gives way along the arc, per force over B

    def angle_rad(self, position_m: float) -> float:
        """Polar angle of a position."""
        return self.origin_rad + position_m / self.radius_m


def _directions(phi_rad: FloatArray) -> FloatArray:
    return np.column_stack((np.cos(phi_rad), np.sin(phi_rad)))


class ContactState:
    """Equilibria of one chain with one arc."""

    def __init__(self, chain: Chain, arc: ContactArc) -> None:
        self.chain = chain
        self.arc = arc

    def free_crossing(self, free: Equilibrium) -> Equilibrium | None:
        """Return the free chain, touched without force where it first crosses the arc, or None."""
        from sim_hardware.world.chain import contact_kernels

        chain, offset = self.chain, self.arc.roll_offset_m
        distance = np.hypot(*chain.corners(free.phi_rad).T)
        outside = np.flatnonzero(distance >= self.arc.radius_m)
        if outside.size == 0:
            return None
        s = (outside[0] - 0.5) * chain.h_m
        towards = _directions(free.phi_rad)
        for _ in range(20):
            x, y, x1, y1, _, _ = contact_kernels.touch(towards, s, chain.h_m, offset)
            r = math.hypot(x, y)
            step = (r - self.arc.radius_m) / ((x * x1 + y * y1) / r)
            s -= step
            if abs(step) < 1e-13:
                break
        if not s <= chain.sheet.visible_m:
            return None
        return replace(free, s_m=s, angle_rad=math.atan2(y1, x1))

    def polar_angle_rad(self, state: Equilibrium) -> float:
        """Return where on the arc the chain is touched."""
        from sim_hardware.world.chain import contact_kernels

        towards, offset = _directions(state.phi_rad), self.arc.roll_offset_m
        x, y, *_ = contact_kernels.touch(towards, state.s_m, self.chain.h_m, offset)
        return math.atan2(y, x)

    def solve(self, start: Equilibrium, drive: float, angle_rad: float) -> Equilibrium | None:
        """Return the equilibrium near `start` at a drive and a polar angle; None: there is none."""
        from sim_hardware.world.chain import contact_kernels, kernels

        arc, chain = self.arc, self.chain
        ux, uy = math.cos(angle_rad), math.sin(angle_rad)
        roll = contact_kernels.ContactPoint(
            arc.radius_m * ux, arc.radius_m * uy, arc.roll_offset_m, arc.friction
        )
        x, y = math.cos(start.angle_rad), math.sin(start.angle_rad)
        phi = start.phi_rad.copy()
        push_x = -(start.along_per_m2 * -uy + start.outward_per_m2 * ux)
        push_y = -(start.along_per_m2 * ux + start.outward_per_m2 * uy)
        contact = np.array([start.s_m, push_x, push_y])
        hinges = chain.hinges(drive)
        end_m = chain.sheet.visible_m
        status = contact_kernels.relax_touched(phi, contact, hinges, roll, end_m)
        if status != kernels.SOLVED:
            return None
        s, fx, fy = (float(value) for value in contact)
        _, _, x, y, _, _ = contact_kernels.touch(_directions(phi), s, chain.h_m, arc.roll_offset_m)
        angle = math.atan2(y, x)
        return Equilibrium(
            drive=drive,
            phi_rad=phi,
            s_m=s,
            angle_rad=angle,
            normal_per_m2=fx * math.sin(angle) - fy * math.cos(angle),
            along_per_m2=fx * uy - fy * ux,
            outward_per_m2=-(fx * ux + fy * uy),
        )

    def push_to(self, start: Equilibrium, angle_rad: float) -> Equilibrium | None:
        """Follow the chain from a touched state along the arc; None: it slips out on the way."""
        here, state = self.polar_angle_rad(start), start
        step = _LONGEST_STEP_RAD
        while here != angle_rad:
            there = here + max(-step, min(step, angle_rad - here))
            found = self.solve(state, state.drive, there)
            if found is not None and abs(found.s_m - state.s_m) < 0.3 * self.arc.radius_m:
                state, here, step = found, there, min(2 * step, _LONGEST_STEP_RAD)
            elif step < _SHORTEST_STEP_RAD:
                return None
            else:
                step /= 4
        return state

    def drive_to(
        self, start: Equilibrium, drive: float, angle_rad: float
    ) -> tuple[Equilibrium, bool]:
        """Follow a held chain as the drive changes; return the state, and whether it got there."""
        state, step = start, _LONGEST_DRIVE
        while state.drive != drive:
            there = state.drive + max(-step, min(step, drive - state.drive))
            found = self.solve(state, there, angle_rad)
            if found is not None and abs(found.s_m - state.s_m) < 0.3 * self.arc.radius_m:
                state, step = found, min(2 * step, _LONGEST_DRIVE)
            elif step < _SHORTEST_DRIVE:
                return state, False
            else:
                step /= 4
        return state, True

    def yielded(self, state: Equilibrium, angle_rad: float) -> Equilibrium:
        """Return the state after an object at `angle_rad` has given way to the force on it."""
        if self.arc.give_rad_m2 == 0.0:
            return state
        for _ in range(_GIVE_ROUNDS):
            moved = self.push_to(state, angle_rad + self.arc.give_rad_m2 * state.along_per_m2)
            if moved is None:
                break
            state = moved
        return state

    def place(self, drive: float, angle_rad: float) -> Equilibrium | None:
        """Return the held chain at a drive, reached from its free shape; None: not reachable."""
        start = self.free_crossing(self.chain.free(drive))
        return None if start is None else self.push_to(start, angle_rad)
