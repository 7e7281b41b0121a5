"""Strips, drive and instruments over the time of a run, and the hooks of what is hidden."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from benchmarks.worlds.generators._collocation_bvp import A, Problem, Strip, solved

LEVELS = np.array([0.0, 0.4, 0.75, 1.0, 1.25, 1.6])  # |alpha| at which the strip is solved
HZ = 80.0
RISE_S = 0.015  # of the voltage, as the operator states it


@dataclass(kw_only=True)
class Stay:
    """The time at one position, or free; arrays (samples,)."""

    configuration: str
    stated_m: float | None
    mounting: int
    approach: str
    from_s: float  # since the session began
    moist_s: float  # since the moistening, at the beginning
    sample_s: float
    t: A
    volts: A
    count: A  # pulses before this one; -1 at 0 V
    age_s: A  # of the pulse
    share: A  # of the session
    worked: A  # time under voltage since the moistening, over 13.2 s
    wrong_m: float = 0.0  # set-up scatter
    eibm: float = 1.0
    stiffness: float = 1.0


@dataclass(frozen=True)
class Load:
    """What acts on the load cell, (samples,)."""

    shown_N: A
    outwards_N: A
    gamma_rad: A


@dataclass
class Plant:
    """What there is, and what is hidden in it."""

    strips: dict[str, Strip]
    stage: list[Callable[[float], float]] = field(default_factory=list)  # m -> m
    drag_N: float = 0.0
    response: list[Callable[[Stay, A], A]] = field(default_factory=list)  # alpha -> alpha
    stiffness: list[Callable[[Stay, A], A]] = field(default_factory=list)  # factor, of alpha
    swelling: list[Callable[[Stay], A]] = field(default_factory=list)  # 1/m
    cell: list[Callable[[Stay, Load], A]] = field(default_factory=list)  # N
    lens: list[Callable[[A, A], tuple[A, A]]] = field(default_factory=list)  # m


@dataclass(frozen=True)
class Grid:
    """Solutions of a stay: columns F/B, outward force/B, gamma, x..., y...."""

    still: A  # (columns,)
    driven: A  # (2 polarities, levels, columns)
    still_swollen: A  # the same per 1/m of rest curvature
    driven_swollen: A


def grids(plant: Plant, strip: Strip, stays: list[Stay], points_m: A) -> list[Grid]:
    """Solve all stays of a configuration at all levels of the drive."""
    alpha = np.concatenate([[0.0], LEVELS, -LEVELS])
    each = len(alpha)
    place = np.repeat([_place_m(plant, stay) for stay in stays], each)
    problem = Problem(place, np.tile(alpha, len(stays)), np.zeros(len(place)), np.zeros(len(place)))
    if plant.drag_N:
        problem = _dragged(plant, strip, problem)
    plain = _columns(strip, problem, points_m)
    swollen = np.zeros_like(plain)
    if plant.swelling:
        more = Problem(problem.place_m, problem.alpha, problem.more_per_m + 2.0, problem.rub_N)
        swollen = (_columns(strip, more, points_m) - plain) / 2.0
    made = []
    for i in range(len(stays)):
        a, b = (v[i * each : (i + 1) * each] for v in (plain, swollen))
        shape = (2, len(LEVELS), -1)
        made.append(Grid(a[0], a[1:].reshape(shape), b[0], b[1:].reshape(shape)))
    return made


def _place_m(plant: Plant, stay: Stay) -> float:
    if stay.stated_m is None:
        return float("nan")
    place = stay.stated_m
    for moved in plant.stage:
        place = moved(place)
    return place + stay.wrong_m


def _columns(strip: Strip, problem: Problem, points_m: A) -> A:
    found = solved(strip, problem, points_m)
    return np.column_stack([found.along_arc, found.outwards, found.gamma_rad, found.x_m, found.y_m])


def _dragged(plant: Plant, strip: Strip, problem: Problem) -> Problem:
    """Return the problem with the drag of the rolls, against how the strip went through them.

    It came from the other polarity; at 0 V from a place 0.5 mm lower.
    """
    if not np.isfinite(problem.place_m).any():
        return problem
    each, levels = 1 + 2 * len(LEVELS), len(LEVELS)
    origin = np.zeros(1)
    contact = solved(strip, problem, origin).contact_m.reshape(-1, each)
    lower = problem.place_m[::each] - 5e-4
    zeros = np.zeros(len(lower))
    came = solved(strip, Problem(lower, zeros, zeros, zeros), origin).contact_m
    way = np.empty_like(contact)
    way[:, 0] = contact[:, 0] - came
    way[:, 1 : levels + 1] = (contact[:, levels] - contact[:, -1])[:, None]
    way[:, levels + 1 :] = -way[:, 1 : levels + 1]
    rub = plant.drag_N * np.tanh(way.ravel() / 1e-5)
    return Problem(problem.place_m, problem.alpha, problem.more_per_m, rub)


# ---------------------------------------------------------------------------- over time


@dataclass(frozen=True)
class Course:
    """alpha, stiffness over its nominal value, and added rest curvature: (samples,)."""

    alpha: A
    stiffness: A
    swollen_per_m: A


def course(plant: Plant, stay: Stay) -> Course:
    """Return how the strip is driven in a stay."""
    alpha = lagged(stay.volts / 2.0, RISE_S) * stay.eibm
    for respond in plant.response:
        alpha = respond(stay, alpha)
    stiffness = np.full_like(alpha, stay.stiffness)
    for factor in plant.stiffness:
        stiffness = stiffness * factor(stay, alpha)
    swollen = np.zeros_like(alpha)
    for swell in plant.swelling:
        swollen = swollen + swell(stay)
    return Course(alpha, stiffness, swollen)


def lagged(target: A, tau_s: float) -> A:
    """Return what follows its target with a time constant; the target is even between samples."""
    if tau_s <= 0.0:
        return target
    keep = float(np.exp(-1.0 / (HZ * tau_s)))
    out, here = np.empty_like(target), float(target[0])
    for i, goal in enumerate(target.tolist()):
        here = goal + (here - goal) * keep
        out[i] = here
    return out


def between(grid: Grid, alpha: A, swollen_per_m: A, columns: slice) -> A:
    """Return rows of the grid at any alpha, a polynomial in it on either side of 0."""
    basis = np.ones((len(alpha), len(LEVELS)))
    for i, level in enumerate(LEVELS):
        for other in np.delete(LEVELS, i):
            basis[:, i] *= (np.abs(alpha) - other) / (level - other)
    basis = basis[:, :, None]
    rows = np.zeros((len(alpha), len(grid.still[columns])))
    for sign, side in ((alpha > 0.0, 0), (alpha < 0.0, 1)):
        plain = np.sum(basis[sign] * grid.driven[side][:, columns], axis=1)
        swollen = np.sum(basis[sign] * grid.driven_swollen[side][:, columns], axis=1)
        rows[sign] = plain + swollen * swollen_per_m[sign, None]
    still = alpha == 0.0
    swollen = grid.still_swollen[columns] * swollen_per_m[still, None]
    rows[still] = grid.still[columns] + swollen
    return rows


def shown_N(plant: Plant, stay: Stay, grid: Grid, now: Course) -> A:
    """Return the load cell's display without noise, over the samples."""
    if stay.stated_m is None:
        return np.zeros_like(stay.t)
    rows = between(grid, now.alpha / now.stiffness, now.swollen_per_m, slice(0, 3))
    scale = plant.strips[stay.configuration].B_Nm2 * now.stiffness
    force, out = rows[:, 0] * scale, rows[:, 1] * scale
    for change in plant.cell:
        force = change(stay, Load(force, out, rows[:, 2]))
    return force


def seen_m(
    plant: Plant, stay: Stay, grid: Grid, now: Course, at_s: A, points_m: A
) -> tuple[A, A, A]:
    """Return s, x, y (readings, points) without noise."""
    i = np.clip(np.searchsorted(stay.t, at_s), 0, len(stay.t) - 1)
    rows = between(grid, (now.alpha / now.stiffness)[i], now.swollen_per_m[i], slice(3, None))
    x, y = np.split(rows, 2, axis=1)
    s = np.broadcast_to(points_m, x.shape).copy()
    for lens in plant.lens:
        chord = np.hypot(np.diff(x), np.diff(y))
        x, y = lens(x, y)
        longer = np.hypot(np.diff(x), np.diff(y)) / chord
        s[:, 1:] = np.cumsum(np.diff(s) * longer, axis=1)
    return s, x, y
