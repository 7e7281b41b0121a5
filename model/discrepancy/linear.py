"""The data about a state: residuals, derivatives, and what scatters from one set-up to the next."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy.point import Active, State, Step, Study, rise_left
from model.effects.interface import Beam
from model.measurements import FloatArray
from model.noise import Data

# Standard deviations from one set-up to the next, as assumed, and how sure that is (of its ln).
ASSUMED = {
    "stiffness": (0.01, 0.8),
    "eibm": (0.01, 0.8),
    "position": (5e-5, 0.8),
    "clamp_tilt": (2e-4, 1.0),
    "registration": (5e-6, 1.0),
    "force_zero": (1e-5, 1.0),
    "eibm_condition": (0.001, 1.0),
    "sway_slow": (1e-5, 1.2),  # N, the load cell's slow wander during a run
    "sway_quick": (1e-5, 1.2),
    "pulse_level": (5e-6, 1.0),
    "pulse_edge": (1.0, 0.3),  # in units of what is known of the edges' times
}
WANDER_S = {"sway_slow": 40.0, "sway_quick": 3.0}
LEAST_MODE_M = 1e-7
WIDE = {"lnB": 1e3, "eibm": 300.0}  # prior widths of the base parameters


@dataclass(frozen=True)
class Base:
    """Base parameters of one configuration in the vector of all."""

    stiffness: int
    eibm: dict[float, tuple[int, float]]  # voltage -> place, sign
    rest: dict[int, FloatArray]  # place -> change of k0 at the nodes by it
    prior: dict[int, tuple[float, float]]  # place -> mean, width


@dataclass(frozen=True)
class Bases:
    """Places of all base parameters."""

    parts: tuple[Base, ...]
    size: int

    def beam(self, study: Study, c: int, theta: FloatArray) -> Beam:
        """The base model of a configuration."""
        one, scene = self.parts[c], study.scenes[c]
        rest = sum((theta[i] * row for i, row in one.rest.items()), np.zeros(scene.count))
        eibm = {v: sign * float(theta[i]) for v, (i, sign) in one.eibm.items()}
        return scene.beam(float(np.exp(theta[one.stiffness])), eibm, np.asarray(rest))

    def names(self, study: Study) -> list[str]:
        """For messages."""
        result = [""] * self.size
        for name, one in zip(study.names, self.parts, strict=True):
            result[one.stiffness] = f"{name} B"
            for v, (i, _) in one.eibm.items():
                result[i] = f"{name} EIBM {v:+g} V"
            for i in one.rest:
                result[i] = f"{name} k0"
        return result


def base_steps(study: Study, bases: Bases, c: int, state: State, base: Beam) -> dict[int, Step]:
    """Derivatives by the base parameters of a configuration."""
    one, scene, G = bases.parts[c], study.scenes[c], study.scenes[c].count
    result = {}
    none = study.no_step(c)
    by = np.zeros_like(none.beam)
    by[:, -2] = 1.0
    result[one.stiffness] = replace(none, beam=by)
    for voltage, (i, sign) in one.eibm.items():
        by = np.zeros_like(none.beam)
        own = scene.voltage_V == voltage
        by[own, :G] = sign * _form(state.beam.eibm[own], base.eibm[own]) * state.beam.soft[own]
        if i in result:  # one |EIBM| for both polarities
            by += result[i].beam
        result[i] = replace(none, beam=by)
    for i, row in one.rest.items():
        by = np.zeros_like(none.beam)
        by[:, :G] = row
        result[i] = replace(none, beam=by)
    return result


def _form(shaped: FloatArray, base: FloatArray) -> FloatArray:
    """The EIBM along the sheet as effects have shaped it: it goes in proportion to its size."""
    there = np.abs(base) > 1e-9
    return np.where(there, shaped / np.where(there, base, 1.0), 1.0)


def scatter_columns(study: Study, c: int, state: State) -> dict[str, list[FloatArray]]:
    """Rows of one configuration by what differs from set-up to set-up, each shared by a run."""
    scene, part = study.scenes[c], study.part(c)
    G, none = scene.count, study.no_step(c)
    result: dict[str, list[FloatArray]] = {}

    def beam(column: int | slice, value: FloatArray | float) -> FloatArray:
        by = np.zeros_like(none.beam)
        by[:, column] = value
        return by

    active = state.beam.eibm * state.beam.soft
    stiff = beam(slice(0, G), -active) + beam(-2, 1.0)
    steps = {
        "stiffness": replace(none, beam=stiff),
        "eibm": replace(none, beam=beam(slice(0, G), active)),
        "position": replace(
            none,
            beam=(beam(2 * G + 1, 1.0) + beam(2 * G + 3, 1.0)) / scene.sheet.arc_radius_m,
        ),
        "clamp_tilt": replace(
            none, beam=beam(2 * G + 1, -1.0) + beam(2 * G + 3, -1.0) + beam(-1, 1.0)
        ),
        "force_zero": replace(none, force_N=np.ones(len(part.reading_of))),
    }
    for name, step in steps.items():
        result[name] = [study.rows_of(c, state, step)]
    result["registration"] = [
        study.rows_of(c, state, replace(none, points_m=n))
        for n in (state.solved.nx, state.solved.ny)
    ]
    rise = max(scene.sheet.rise_time_s, 1e-3)
    late = rise_left(part.bin_clock, rise, part.edge_s) - rise_left(part.bin_clock, rise, 0.0)
    result["pulse_edge"] = [study.rows_of(c, state, replace(none, bin_eibm=part.bin_mean(late)))]
    each = []
    for k in range(scene.K):
        if scene.voltage_V[k] != 0.0:
            by = np.zeros_like(none.beam)
            by[k, :G] = active[k]
            each.append(study.rows_of(c, state, replace(none, beam=by)))
    result["eibm_condition"] = each
    return result


def wander(study: Study, name: str) -> list[FloatArray]:
    """The load cell's slow wander during a run, as columns (N,) of a factor of its covariance."""
    columns = []
    for part in study.layout.parts:
        clock = part.clock.run_s
        run = study.layout.run_of[part.trend_rows]
        for r in np.unique(run):
            rows = part.trend_rows[run == r]
            T = part.trend[run == r]
            use = np.flatnonzero(np.any(T != 0.0, axis=0))
            apart = np.abs(clock[use][:, None] - clock[use])
            kernel = np.exp(-apart / WANDER_S[name])
            V = T[:, use] @ kernel @ T[:, use].T
            values, vectors = np.linalg.eigh(V)
            for j in np.flatnonzero(values > 1e-6 * max(values[-1], 1e-300)):
                column = np.zeros(study.layout.size)
                column[rows] = vectors[:, j] * np.sqrt(values[j])
                columns.append(column)
    return columns


def pulse_levels(study: Study) -> list[FloatArray]:
    """All parts of a pulse share the error of the sampling point's force."""
    columns = []
    for part in study.layout.parts:
        for p in np.unique(part.bin_set):
            column = np.zeros(study.layout.size)
            column[part.bin_rows[part.bin_set == p]] = 1.0
            columns.append(column)
    return columns


def by_run(study: Study, columns: list[FloatArray]) -> FloatArray:
    """Columns (N,) that touch one run each, or all: packed as (R, n, q)."""
    layout, R = study.layout, len(study.layout.runs)
    packed: list[list[FloatArray]] = [[] for _ in range(R)]
    for column in columns:
        for r in np.unique(layout.run_of[np.flatnonzero(column)]):
            packed[r].append(np.where(layout.run_of == r, column, 0.0))
    q = max([1, *(len(p) for p in packed)])
    flat = np.zeros((layout.size, q))
    for own in packed:
        for j, column in enumerate(own):
            flat[:, j] += column
    return layout.pad(flat)


@dataclass(frozen=True)
class Noise:
    """Fixed variances, further noises and their priors; the same for all states."""

    fixed: FloatArray  # (N,)
    masks: list[FloatArray]  # (N,)
    names: list[str]
    guess: FloatArray
    width: FloatArray
    constant: dict[str, FloatArray]  # groups (R, n, q) that are the same for all states


def noise_of(study: Study) -> Noise:
    """Readings, modes, sways and pulses of each configuration have a noise of their own."""
    N = study.layout.size
    fixed, masks, names, guess, width = np.zeros(N), [], [], [], []

    def add(
        name: str, rows: FloatArray, weight: FloatArray | float, size: float, unsure: float
    ) -> None:
        mask = np.zeros(N)
        mask[rows] = weight
        masks.append(mask)
        names.append(name)
        guess.append(np.log(size))
        width.append(unsure)

    for name, part, scene, look in zip(
        study.names, study.layout.parts, study.scenes, study.looks, strict=True
    ):
        counts = np.maximum(np.bincount(part.reading_of, minlength=scene.K), 1)
        if len(part.trend_rows):
            weight = np.where(part.is_mean, 1.0 / counts[part.trend_of], 1.0)
            size, unsure = _reading_noise(part.trend, part.measured_N, part.reading_of)
            add(f"{name} reading", part.trend_rows, weight, size, unsure)
        stated = [o.curve.sigma_m for o in look.seen if o.curve is not None]
        known = [float(np.mean(s)) for s in stated if s is not None]
        typical = max(float(np.mean(known)) if known else 2e-5, 5e-7)
        for m in range(scene.modes):
            rows = part.mode_rows[scene.has_curve, m]
            if len(rows):
                add(f"{name} mode {m}", rows, 1.0, typical / (1.0 + m), 1.5)
                fixed[rows] = LEAST_MODE_M**2
        if len(part.sway_rows):
            add(f"{name} sway", part.sway_rows, 1.0, 3e-3, 2.0)
        if len(part.bin_rows):
            # the scatter of the pulses says how sure each part is, up to a factor near one
            fixed[part.bin_rows] = 1e-16
            pooled = _pooled(part.bin_variance, part.bin_set)
            add(f"{name} pulse", part.bin_rows, pooled, 1.0, 0.3)
    constant = {name: by_run(study, wander(study, name)) for name in WANDER_S}
    constant["pulse_level"] = by_run(study, pulse_levels(study))
    return Noise(fixed, masks, names, np.array(guess), np.array(width), constant)


def _reading_noise(trend: FloatArray, measured: FloatArray, of: FloatArray) -> tuple[float, float]:
    """Standard deviation of a reading about its trend in time, and of its logarithm."""
    total, degrees = 0.0, 0
    for k in np.unique(of):
        own = of == k
        rows = trend[np.any(trend[:, own] != 0.0, axis=1)][:, own]
        n = int(own.sum())
        if n <= len(rows):
            continue
        values = measured[own]
        smooth = n * values.mean() ** 2 + float(np.sum((rows[1:] @ values) ** 2))
        total += float(values @ values) - smooth
        degrees += n - len(rows)
    if not degrees:
        return 3e-5, 1.5
    return max(float(np.sqrt(max(total, 0.0) / degrees)), 1e-7), max(0.05, (2.0 * degrees) ** -0.5)


def _pooled(variance: FloatArray, sets: FloatArray) -> FloatArray:
    """The same part of a pulse scatters alike in all runs."""
    count = int(np.bincount(sets)[0])
    table = variance.reshape(-1, count)
    return np.maximum(np.tile(np.median(table, axis=0), len(table)), 1e-16)


@dataclass(frozen=True)
class Linear:
    """The data about a point: base parameters and active effects as columns of `data.X`."""

    states: tuple[State, ...]
    residual: FloatArray  # (N,)
    columns: FloatArray  # (N, p)
    data: Data
    names: tuple[str, ...]  # of the columns


def linearise(
    study: Study,
    bases: Bases,
    noise: Noise,
    theta: FloatArray,
    active: tuple[Active, ...] = (),
    extra: FloatArray | None = None,
) -> Linear:
    """Everything about a point; `extra` (N, q) are more columns, each with unit prior variance."""
    N, states = study.layout.size, []
    residual, columns = np.zeros(N), np.zeros((N, bases.size))
    scatter: dict[str, list[FloatArray]] = {}
    for c in range(len(study.names)):
        base = bases.beam(study, c, theta)
        state = study.state(c, base, active)
        states.append(state)
        residual += state.residual
        for i, step in base_steps(study, bases, c, state, base).items():
            columns[:, i] += study.rows_of(c, state, step)
        for name, found in scatter_columns(study, c, state).items():
            scatter.setdefault(name, []).extend(found)
    names = bases.names(study)
    precision = np.array([_prior(bases, i)[1] ** -2.0 for i in range(bases.size)])
    away = np.array([theta[i] - _prior(bases, i)[0] for i in range(bases.size)])
    groups = []
    for name in ASSUMED:
        if name in noise.constant:
            groups.append(noise.constant[name])
        elif name == "registration":
            one = [scatter[name][i::2] for i in (0, 1)]
            groups.append(np.concatenate([by_run(study, [np.sum(o, axis=0)]) for o in one], axis=2))
        elif name == "eibm_condition":
            groups.append(by_run(study, scatter[name]))
        else:
            groups.append(by_run(study, [np.sum(scatter[name], axis=0)]))
    pad = study.layout.pad
    empty = pad(np.ones(N)) == 0.0
    data = Data(
        pad(residual), pad(columns), groups, [pad(m) for m in noise.masks],
        np.where(empty, 1.0, pad(noise.fixed)), precision, away,
        np.concatenate([[w for _, w in ASSUMED.values()], noise.width]),
    )  # fmt: skip
    linear = Linear(tuple(states), residual, columns, data, tuple(names))
    return linear if extra is None else with_columns(study, linear, extra)


def with_columns(
    study: Study, linear: Linear, extra: FloatArray, precision: FloatArray | float = 1.0,
    away: FloatArray | float = 0.0,
) -> Linear:  # fmt: skip
    """More columns (N, q) with Gaussian priors."""
    q = extra.shape[1]
    X = np.concatenate([linear.data.X, study.layout.pad(extra)], axis=2)
    data = replace(
        linear.data, X=X,
        precision=np.concatenate([linear.data.precision, np.broadcast_to(precision, q)]),
        away=np.concatenate([linear.data.away, np.broadcast_to(away, q)]),
    )  # fmt: skip
    return replace(linear, columns=np.concatenate([linear.columns, extra], axis=1), data=data)


def guess_of(noise: Noise) -> FloatArray:
    """Ln of all standard deviations, as assumed."""
    return np.concatenate([[np.log(v) for v, _ in ASSUMED.values()], noise.guess])


def _prior(bases: Bases, i: int) -> tuple[float, float]:
    for one in bases.parts:
        if i in one.prior:
            return one.prior[i]
        if i == one.stiffness:
            return 0.0, WIDE["lnB"]
    return 0.0, WIDE["eibm"]
