"""Many steps of a moving sheet with electrodes and load cell, compiled. Import where it is used.

A row of the grid belongs to a time t_k. Made are then the angles up to t_k + dt, so that a shape in
between is interpolated; the double layers' voltages and the contact's force are those of t_k.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from sim_hardware.jit import brief_jit
from sim_hardware.world.motion.ladder import Ladder, charge
from sim_hardware.world.motion.links import LOST, STEPPED, Links, Room, step
from sim_hardware.world.motion.touch import touched

Floats = npt.NDArray[np.float64]

# Columns of a row; the force is the sheet's alone. CELL and CELL_RATE: what the load cell shows.
FORCE, SLOPE, CELL, CELL_RATE, BACK, SINK, S, ANGLE, HELD = range(9)
COLUMNS = 9

# A state that changes by less than this in a step is at rest, and stays so until it is disturbed.
_STILL_RAD = 1e-12
_STILL_V = 1e-10
_ROUNDING_V = 1e-9  # of a mean that is a difference of integrals


class Law(NamedTuple):
    """From the double layers' voltage to the bending moment, hinge by hinge (n + 1,)."""

    odd_Nm: Floats  # Me at 2 V of what changes its sign with the voltage
    even_Nm: Floats  # Me at 2 V of what does not
    saturation_V: float
    negative_ratio: float


class Course(NamedTuple):
    """What happens to the sheet from outside: one entry a step (m,)."""

    drive_V: Floats  # of the source, mean over the step
    share: Floats  # of Me that water and drying leave, at its end
    stiff: Floats  # B over that of a wet sheet, at its end
    axis_rad: Floats  # direction of the load cell's axis, at its end
    beside_N: Floats  # on the load cell beside the sheet's force, at its end
    held_N: Floats  # the same, while the sheet is held
    roll_x_m: Floats  # where the rolls will be a step after that
    roll_y_m: Floats
    clamp_rad: Floats  # and the clamp's direction


class ChainState(NamedTuple):
    """All that the next step depends on; changed in place."""

    phi: Floats  # (3, n + 1): before, now, next
    lag: Floats  # (2, p, n + 1)
    U: Floats  # (n,)
    contact: Floats  # (3,): see `links.step`
    row: Floats  # (COLUMNS,): the newest
    outside: Floats  # (6,): what the last step met
    flags: npt.NDArray[np.int64]  # (2,): which lag is now; whether all is at rest


@brief_jit
def ring(
    x: float, rate: float, force: float, slope: float, after: float, omega: float, damping: float
) -> tuple[float, float]:
    """Deflection (as a force) and rate of a load cell `after` so long; the force goes in a line."""
    y = x - force + 2.0 * damping * slope / omega
    v = rate - slope
    swing = omega * math.sqrt(1.0 - damping * damping)
    cos, sin = math.cos(swing * after), math.sin(swing * after)
    left = math.exp(-damping * omega * after)
    other = (v + damping * omega * y) / swing
    new = left * (y * cos + other * sin)
    new_rate = left * (other * swing * cos - y * swing * sin) - damping * omega * new
    return new + force + slope * after - 2.0 * damping * slope / omega, new_rate + slope


@brief_jit
def rings(start: Floats, after: Floats, omega: float, damping: float) -> Floats:
    """Return what the load cell shows (m,), so long after rows `start` (m, FORCE to CELL_RATE)."""
    shown = np.empty(after.shape[0])
    for k in range(after.shape[0]):
        force, slope, x, rate = start[k, 0], start[k, 1], start[k, 2], start[k, 3]
        shown[k], _ = ring(x, rate, force, slope, after[k], omega, damping)
    return shown


@brief_jit
def _moments(law: Law, share: float, U: Floats, moment: Floats) -> None:
    whole = math.tanh(2.0 / law.saturation_V)
    for i in range(U.shape[0]):
        part = math.tanh(U[i] / law.saturation_V) / whole
        if part < 0.0:
            part *= law.negative_ratio
        moment[i + 1] = share * part * (law.odd_Nm[i + 1] + part * law.even_Nm[i + 1])


@brief_jit
def _disturbed(state: ChainState, course: Course, k: int) -> bool:
    """Whether anything outside has changed since it last did; remember it."""
    now = (
        course.drive_V[k], course.share[k], course.stiff[k],
        course.roll_x_m[k], course.roll_y_m[k], course.clamp_rad[k],
    )  # fmt: skip
    for j in range(6):
        least = _ROUNDING_V if j == 0 else _STILL_RAD
        if not abs(now[j] - state.outside[j]) <= least:
            for i in range(6):
                state.outside[i] = now[i]
            return True
    return False


@brief_jit
def _still(state: ChainState) -> bool:
    for i in range(state.phi.shape[1]):
        if abs(state.phi[2, i] - state.phi[1, i]) > _STILL_RAD:
            return False
        if abs(state.phi[1, i] - state.phi[0, i]) > _STILL_RAD:
            return False
        for p in range(state.lag.shape[1]):
            if abs(state.lag[0, p, i] - state.lag[1, p, i]) > _STILL_RAD:
                return False
    return True


@brief_jit
def _move(
    links: Links, law: Law, dt: float, course: Course, k: int, end_m: float, state: ChainState,
    moment: Floats, space: Room,
) -> int:  # fmt: skip
    """Step the chain; a sheet that cannot be held any longer slips out of the rolls."""
    phi, contact, row = state.phi, state.contact, state.row
    _moments(law, course.share[k], state.U, moment)
    for i in range(phi.shape[1]):
        phi[0, i], phi[1, i] = phi[1, i], phi[2, i]
    contact[0] = contact[2]
    for held in (row[HELD] == 1.0, False):
        for i in range(phi.shape[1]):
            phi[2, i] = 2.0 * phi[1, i] - phi[0, i]
        phi[2, 0] = course.clamp_rad[k]
        status = step(
            links, course.stiff[k], dt, phi, state.lag, now=state.flags[0], moment=moment,
            contact=contact, held=held, roll_x=course.roll_x_m[k], roll_y=course.roll_y_m[k],
            end_m=end_m, space=space,
        )  # fmt: skip
        if status == STEPPED or not held:
            break
        row[HELD], contact[1] = 0.0, 0.0
    state.flags[0] = 1 - state.flags[0]
    return int(status)


@brief_jit
def march(
    links: Links, line: Ladder, law: Law, omega: float, damping: float, dt: float, end_m: float,
    course: Course, state: ChainState, space: Room, rows: Floats, shapes: Floats,
) -> int:  # fmt: skip
    """Fill `rows` (m, COLUMNS) and `shapes` (m, n + 1); return how many could be made."""
    row, contact = state.row, state.contact
    moment = np.zeros(state.phi.shape[1])
    work = np.empty(state.U.shape[0])
    for k in range(rows.shape[0]):
        change_V = 0.0
        if _disturbed(state, course, k):
            state.flags[1] = 0
        before = row[FORCE]
        if state.flags[1] == 0:
            change_V = charge(line, course.drive_V[k], state.U, work)
            moved = _move(
                links, law, dt, course, k, end_m=end_m, state=state, moment=moment, space=space
            )
            if moved == LOST:
                return k
            state.flags[1] = 1 if change_V < _STILL_V and _still(state) else 0
            row[BACK] = row[SINK] = 0.0
            for i in range(work.shape[0]):
                row[BACK] += line.back_S[i] * state.U[i]
                row[SINK] += line.sink_S_per_s[i] * state.U[i]
            if row[HELD] == 1.0:
                _, _, tx, ty = touched(space.towards[1], contact[0], links.h_m)
                row[S], row[ANGLE] = contact[0], math.atan2(ty, tx)
        force = course.beside_N[k]
        if row[HELD] == 1.0:
            force += contact[1] * math.cos(row[ANGLE] - course.axis_rad[k]) + course.held_N[k]
        slope = (force - before) / dt
        shown, rate = ring(row[CELL], row[CELL_RATE], before, slope, dt, omega, damping)
        row[FORCE], row[SLOPE], row[CELL], row[CELL_RATE] = force, slope, shown, rate
        for j in range(row.shape[0]):
            rows[k, j] = row[j]
        for i in range(shapes.shape[1]):
            shapes[k, i] = state.phi[2, i]
    return int(rows.shape[0])
