"""What kinds of the world `legendre` do in time."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.worlds.generators._legendre_ritz import Array, Cases
from benchmarks.worlds.generators._legendre_specimen import DRIVE_V, RISE_S
from benchmarks.worlds.session.effects import Load, Sheet
from benchmarks.worlds.session.layout import FRAME, Samples

PULSE_S = 0.6
Change = Callable[[Cases, Samples, Sheet, float], None]
Factor = Callable[[Samples, float], Array]


def eibm(factor: Factor) -> Change:
    """Return a change that multiplies the EIBM."""

    def change(state: Cases, at: Samples, _: Sheet, size: float) -> None:
        state.drive[:] *= factor(at, size)

    return change


def stiffness(factor: Factor) -> Change:
    """Return a change that multiplies the stiffness."""

    def change(state: Cases, at: Samples, _: Sheet, size: float) -> None:
        state.stiffness[:] *= factor(at, size)

    return change


def rest(more: Factor) -> Change:
    """Return a change that adds to the rest curvature, in 1/m."""

    def change(state: Cases, at: Samples, _: Sheet, size: float) -> None:
        state.rest_per_m[:] += more(at, size)

    return change


def place(more_mm: Callable[[Array, Samples, float], Array]) -> Change:
    """Return a change that moves the contact by some mm, from its stated place in mm."""

    def change(state: Cases, at: Samples, _: Sheet, size: float) -> None:
        state.place_m[:] += 1e-3 * more_mm(1e3 * state.place_m, at, size)

    return change


def lagging(state: Cases, at: Samples, sheet: Sheet, size: float) -> None:
    """The EIBM follows what the voltage across the sheet would make it, by a lag in s."""
    scale = float(sheet.eibm_Nm(np.array([DRIVE_V]))[0])
    plain = sheet.eibm_Nm(at.sheet_V) / scale
    gains = {way: float(sheet.eibm_Nm(np.array([way]))[0]) / scale / way for way in (1.0, -1.0)}
    for rows in _runs(at):
        state.drive[rows] += _lagged(at.take(rows), gains, size) - plain[rows]


def _runs(at: Samples) -> list[Array]:
    return [np.flatnonzero(at.run == number) for number in np.unique(at.run)]


def _lagged(at: Samples, gains: dict[float, float], constant_s: float) -> Array:
    """Return what follows a run's voltages by a lag.

    The voltage across the sheet rises exponentially from one drive to the next; where it goes
    through 0 the gain (EIBM per volt) becomes the other polarity's.
    """
    shown, begin = np.empty(len(at.slot)), 0.0
    for slot in np.unique(at.slot):
        rows = np.flatnonzero(at.slot == slot)
        goal, old = float(at.drive_V[rows[0]]), float(at.before_V[rows[0]])
        through = RISE_S * np.log((goal - old) / goal) if goal * old < 0.0 else 0.0
        first = gains[float(np.sign(old or goal or 1.0))]
        last = gains[float(np.sign(goal or old or 1.0))]
        t = np.append(np.maximum(at.phase_s[rows], 0.0), PULSE_S)
        turn = np.array([through])
        early = _reached(t, 0.0, begin, (first * goal, first * (old - goal)), constant_s)
        there = _reached(turn, 0.0, begin, (first * goal, first * (old - goal)), constant_s)
        late = _reached(t, through, float(there[0]), (last * goal, last * (old - goal)), constant_s)
        found = np.where(t < through, early, late)
        shown[rows], begin = found[:-1], float(found[-1])
    return shown


def _reached(
    t: Array, since: float, begin: float, rise: tuple[float, float], constant_s: float
) -> Array:
    """Return what lags behind goal + way exp(-t/RISE_S), from `begin` at the time `since`."""
    goal, way = rise
    slower = RISE_S if abs(constant_s - RISE_S) > 1e-6 else 1.001 * RISE_S
    fast = way * slower / (slower - constant_s) * np.exp(-np.array([since, *t]) / slower)
    slow = begin - goal - fast[0]
    return np.asarray(goal + fast[1:] + slow * _decay(np.maximum(t - since, 0.0), constant_s))


def _decay(t: Array, constant_s: float) -> Array:
    """Return exp(-t/constant), 0 for a lag of no length."""
    if abs(constant_s) < 1e-12:
        return np.where(t > 0.0, 0.0, 1.0)
    return np.asarray(np.exp(-t / abs(constant_s)))


def following(at: Samples, goal: Array, constant_s: float) -> Array:
    """Return what creeps towards `goal`, which is one value in each slot, in each run anew."""
    shown = np.empty(len(goal))
    for rows in _runs(at):
        begin = 0.0
        for slot in np.unique(at.slot[rows]):
            own = rows[at.slot[rows] == slot]
            phase = np.maximum(at.phase_s[own], 0.0)
            shown[own] = goal[own[0]] + (begin - goal[own[0]]) * np.exp(-phase / constant_s)
            begin = goal[own[0]] + (begin - goal[own[0]]) * np.exp(-PULSE_S / constant_s)
    return shown


def play(load: Load, half_N: float) -> Array:
    """Return forces that follow the load with a play to either side, in each run anew."""
    at, shown = load.samples, load.force_N.copy()
    half = abs(half_N)
    for rows in at.each_run():
        last = float(load.force_N[rows[0]]) if len(rows) else 0.0
        for row in rows.tolist():
            force = float(load.force_N[row])
            last = min(max(last, force - half), force + half)
            shown[row] = last
    return shown


def slid(contact_m: Array, at: Samples, dead_m: float) -> Array:
    """Return the sense in which the contact last went along the sheet: 1 is to its end."""
    way = np.zeros(len(contact_m))
    for rows in at.each_run():
        last, sense = float(contact_m[rows[0]]), 1.0  # as it was placed
        for row in rows.tolist():
            moved = float(contact_m[row]) - last
            if abs(moved) > dead_m:
                last, sense = float(contact_m[row]), float(np.sign(moved))
            way[row] = sense
    for row in np.flatnonzero(at.role == FRAME).tolist():
        same = np.flatnonzero((at.run == at.run[row]) & (at.role != FRAME))
        way[row] = way[same[np.argmin(np.abs(at.time_s[same] - at.time_s[row]))]]
    return way
