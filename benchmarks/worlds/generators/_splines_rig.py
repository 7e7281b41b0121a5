"""The rig over time: runs, what the voltage does in them, and the places where kinds act."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from benchmarks.worlds.generators._splines_sheet import A, Cases, Sheet, solve

NODES = np.array([0.0, 0.4, 0.8, 1.0, 1.2, 1.5])  # of |alpha|, where equilibria are solved
RATE_HZ = 100.0


@dataclass(kw_only=True)
class Run:
    """One run: 0 V, then pulses. Arrays are over the samples of the run, (samples,)."""

    configuration: str
    position_m: float | None  # as stated
    mounting: int
    approach: str
    begin_s: float  # since the session began
    wetted_s: float  # at its beginning
    sample_s: float  # after the edge
    time_s: A
    drive_V: A
    pulse: A  # counts the pulses under voltage; -1 at 0 V
    edge_s: A  # since the last edge
    share: A  # of the session, 0 to 1
    eibm: float = 1.0  # set-up scatter, factors
    stiffness: float = 1.0
    moved_m: float = 0.0


@dataclass
class Felt:
    """What the load cell is given, over the samples of a run."""

    force_N: A  # along the arc's tangent
    radial_N: A
    gamma_rad: A


@dataclass
class Rig:
    """Sheets and instruments, and lists of what is hidden in them."""

    sheets: dict[str, Sheet]
    place: list[Callable[[float], float]] = field(default_factory=list)  # stated -> true (m)
    friction: float = 0.0
    swing: list[Callable[[Run, A], A]] = field(default_factory=list)  # alpha -> alpha
    softening: list[Callable[[A], A]] = field(default_factory=list)  # factor of B, of alpha
    stiffness: list[Callable[[Run], A]] = field(default_factory=list)  # factor of B
    warping: list[Callable[[Run], A]] = field(default_factory=list)  # added to k0 (1/m)
    cell: list[Callable[[Run, Felt], A]] = field(default_factory=list)  # N -> N
    view: list[Callable[[A, A], tuple[A, A]]] = field(default_factory=list)  # x, y (m)


@dataclass(frozen=True)
class Table:
    """Solutions of one run: at 0 V and on the nodes of either polarity, and with k0 + 1/m.

    Each row of `values` is (F/B, radial force over B, gamma, x..., y...); (2 polarities, nodes).
    """

    zero: A  # (values,)
    zero_slope: A  # per 1/m of k0
    half: A  # (2, nodes, values)
    half_slope: A


def tables(rig: Rig, name: str, runs: list[Run], points_m: A) -> list[Table]:
    """Solve all runs of a configuration."""
    sheet = rig.sheets[name]
    alpha = np.concatenate([[0.0], NODES, -NODES])
    place = np.array([true_position_m(rig, run) for run in runs])
    where = np.repeat(place, len(alpha))
    swung = np.tile(alpha, len(runs))
    rubs = _rubbing(rig, sheet, where, swung, points_m)
    values = _values(sheet, Cases(where, swung, 0.0 * swung, rubs), points_m)
    slopes = np.zeros_like(values)
    if rig.warping:
        warped = _values(sheet, Cases(where, swung, 0.0 * swung + 1.0, rubs), points_m)
        slopes = warped - values
    value, slope = (v.reshape(len(runs), len(alpha), -1) for v in (values, slopes))
    return [
        Table(v[0], w[0], v[1:].reshape(2, len(NODES), -1), w[1:].reshape(2, len(NODES), -1))
        for v, w in zip(value, slope, strict=True)
    ]


def true_position_m(rig: Rig, run: Run) -> float:
    """Return where the rolls are; nan: they are away."""
    if run.position_m is None:
        return float("nan")
    place = run.position_m
    for f in rig.place:
        place = f(place)
    return place + run.moved_m


def _values(sheet: Sheet, cases: Cases, points_m: A) -> A:
    one = solve(sheet, cases, points_m)
    return np.column_stack([one.tangential, one.radial, one.gamma_rad, one.x_m, one.y_m])


def _rubbing(rig: Rig, sheet: Sheet, where: A, alpha: A, points_m: A) -> A:
    """Return the signed friction: against the way on which the sheet last slid in the rolls.

    Under voltage it came from the opposite one; at 0 V from 1 mm below on the arc.
    """
    none = np.zeros_like(alpha)
    if rig.friction == 0.0 or not np.any(np.isfinite(where)):
        return none
    count = 2 * len(NODES) + 1
    reached = solve(sheet, Cases(where, alpha, none, none), points_m).contact_m
    reached = reached.reshape(-1, count)
    below = solve(sheet, Cases(where[::count] - 1e-3, *3 * (none[::count],)), points_m).contact_m
    plus, minus = (1 + k + int(np.flatnonzero(NODES == 1.0)[0]) for k in (0, len(NODES)))
    slid = np.empty_like(reached)
    slid[:, 0] = reached[:, 0] - below
    slid[:, 1 : len(NODES) + 1] = (reached[:, plus] - reached[:, minus])[:, None]
    slid[:, len(NODES) + 1 :] = (reached[:, minus] - reached[:, plus])[:, None]
    return np.asarray(-rig.friction * np.sign(slid).ravel())


@dataclass(frozen=True)
class State:
    """The sheet in a run, over its samples."""

    alpha: A
    stiffness: A  # factor of B
    warp_per_m: A


def state(rig: Rig, run: Run) -> State:
    """Return what the voltage and the time make of the sheet."""
    alpha = run.drive_V / 2.0 * run.eibm
    for swing in rig.swing:
        alpha = swing(run, alpha)
    stiffness = np.full_like(alpha, run.stiffness)
    for factor in rig.stiffness:
        stiffness = stiffness * factor(run)
    for soften in rig.softening:
        stiffness = stiffness * soften(alpha)
    warp = np.zeros_like(alpha)
    for more in rig.warping:
        warp = warp + more(run)
    return State(alpha, stiffness, warp)


def values(table: Table, alpha: A, warp_per_m: A) -> A:
    """Return rows of the table between its nodes: a polynomial in |alpha| for either polarity."""
    side = (alpha < 0.0).astype(int)
    weight = _lagrange(np.abs(alpha))
    found = np.einsum("tn,tnv->tv", weight, table.half[side])
    slope = np.einsum("tn,tnv->tv", weight, table.half_slope[side])
    still = alpha == 0.0
    found[still], slope[still] = table.zero, table.zero_slope
    return np.asarray(found + slope * warp_per_m[:, None])


def _lagrange(at: A) -> A:
    columns = []
    for i, node in enumerate(NODES):
        others = np.delete(NODES, i)
        columns.append(np.prod((at[:, None] - others) / (node - others), axis=1))
    return np.stack(columns, axis=1)


def forces_N(rig: Rig, run: Run, table: Table, now: State) -> A:
    """Return what the load cell shows, without noise, over the samples of the run."""
    if run.position_m is None:
        return np.zeros_like(run.time_s)
    table = Table(*(v[..., :3] for v in vars(table).values()))
    rows = values(table, now.alpha / now.stiffness, now.warp_per_m)
    B = rig.sheets[run.configuration].B_Nm2 * now.stiffness
    felt = Felt(rows[:, 0] * B, rows[:, 1] * B, rows[:, 2])
    for cell in rig.cell:
        felt.force_N = cell(run, felt)
    return felt.force_N


def curves_m(rig: Rig, run: Run, table: Table, now: State, at_s: A, points_m: A) -> tuple[A, A, A]:
    """Return s, x, y of (readings, points) as the camera sees them, without noise."""
    at = np.array([np.argmin(np.abs(run.time_s - t)) for t in at_s])
    rows = values(table, (now.alpha / now.stiffness)[at], now.warp_per_m[at])
    count = len(points_m)
    x, y = rows[:, 3 : 3 + count], rows[:, 3 + count :]
    s = np.tile(points_m, (len(x), 1))
    if not rig.view:
        return s, x, y
    before = np.hypot(np.diff(x, axis=1), np.diff(y, axis=1))
    for view in rig.view:
        x, y = view(x, y)
    after = np.hypot(np.diff(x, axis=1), np.diff(y, axis=1))
    grown = np.diff(s, axis=1) * after / before
    return np.concatenate([s[:, :1], np.cumsum(grown, axis=1)], axis=1), x, y
