"""What differs from one set-up to the next: columns by which each run may be off by itself.

Packed as in `mixed_model`: each random effect has a matrix Z (R, n, q), the rows of R runs by q
numbers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from model.effects.rise import rise_left
from model.identification.likelihood.forward_model import ForwardModel, ModelState, Perturbation
from model.measurements import FloatArray

# Standard deviations from one set-up to the next, as assumed, and how sure that is (of its ln).
ASSUMED = {
    "stiffness": (0.01, 0.45),
    "eibm": (0.01, 0.45),
    "position": (5e-5, 0.45),
    "clamp_tilt": (2e-4, 0.7),
    "registration": (5e-6, 0.7),
    "force_zero": (1e-5, 0.7),
    "eibm_condition": (0.001, 0.6),
    "eibm_free": (0.003, 0.9),  # of one free shape: each may be taken by itself
    "sway_slow": (1e-5, 1.2),  # N, the load cell's slow wander during a run
    "sway_quick": (1e-5, 1.2),
    "pulse_level": (5e-6, 1.5),
    "pulse_edge": (1.0, 0.3),  # in units of what is known of the edges' times
}
WANDER_S = {"sway_slow": 40.0, "sway_quick": 3.0}  # correlation times
EACH = ("eibm_condition", "eibm_free")  # of which each condition has its own
Columns = dict[str, list[FloatArray]]  # by scatter: columns (N,)


def scatter_columns(study: ForwardModel, c: int, state: ModelState) -> Columns:
    """Rows of one configuration by what differs from set-up to set-up, each shared by a run."""
    none = study.no_step(c)
    result = {
        name: [study.rows_of(c, state, step)]
        for name, step in _setup_steps(study, c, state).items()
    }
    result["registration"] = [
        study.rows_of(c, state, replace(none, points_m=n))
        for n in (state.solved.nx, state.solved.ny)
    ]
    part, scene = study.part(c), study.scenes[c]
    rise = max(scene.sheet.rise_time_s, 1e-3)
    late = rise_left(part.bin_clock, rise, part.edge_s) - rise_left(part.bin_clock, rise, 0.0)
    result["pulse_edge"] = [study.rows_of(c, state, replace(none, bin_eibm=part.bin_mean(late)))]
    result |= {name: [] for name in EACH}
    for k in np.flatnonzero(scene.voltage_V):
        by = np.zeros_like(none.beam)
        by[k, : scene.count] = (state.beam.eibm * state.beam.soft)[k]
        name = "eibm_free" if k in scene.free else "eibm_condition"
        result[name].append(study.rows_of(c, state, replace(none, beam=by)))
    return result


def _setup_steps(study: ForwardModel, c: int, state: ModelState) -> dict[str, Perturbation]:
    """One unit of B, EIBM (relative), position (m), tilt (rad) and the cell's zero (N)."""
    scene, none = study.scenes[c], study.no_step(c)
    G = scene.count

    def beam(column: int | slice, value: FloatArray | float) -> FloatArray:
        by = np.zeros_like(none.beam)
        by[:, column] = value
        return by

    active = state.beam.eibm * state.beam.soft
    on_arc = beam(2 * G + 1, 1.0) + beam(2 * G + 3, 1.0)
    return {
        "stiffness": replace(none, beam=beam(slice(0, G), -active) + beam(-2, 1.0)),
        "eibm": replace(none, beam=beam(slice(0, G), active)),
        "position": replace(none, beam=on_arc / scene.sheet.arc_radius_m),
        "clamp_tilt": replace(none, beam=beam(-1, 1.0) - on_arc),
        "force_zero": replace(none, force_N=np.ones(len(study.part(c).reading_of))),
    }


def constant_groups(study: ForwardModel) -> dict[str, FloatArray]:
    """The scatters that are the same for all states: the load cell's wander, the pulses' levels."""
    groups = {name: by_run(study, _wander(study, name)) for name in WANDER_S}
    groups["pulse_level"] = by_run(study, _pulse_levels(study))
    return groups


def groups_of(
    study: ForwardModel, scatter: Columns, constant: Mapping[str, FloatArray]
) -> list[FloatArray]:
    """All scatters in the order of `ASSUMED`; `scatter` has the columns of all configurations."""
    groups = []
    for name in ASSUMED:
        if name in constant:
            groups.append(constant[name])
        elif name == "registration":  # to the side and along, of one size
            one = [scatter[name][i::2] for i in (0, 1)]
            groups.append(np.concatenate([by_run(study, [np.sum(o, axis=0)]) for o in one], axis=2))
        elif name in EACH:
            groups.append(by_run(study, scatter[name]))
        else:
            groups.append(by_run(study, [np.sum(scatter[name], axis=0)]))
    return groups


def _wander(study: ForwardModel, name: str) -> list[FloatArray]:
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


def _pulse_levels(study: ForwardModel) -> list[FloatArray]:
    """All parts of a pulse share the error of the sampling point's force."""
    columns = []
    for part in study.layout.parts:
        for p in np.unique(part.bin_set):
            column = np.zeros(study.layout.size)
            column[part.bin_rows[part.bin_set == p]] = 1.0
            columns.append(column)
    return columns


def by_run(study: ForwardModel, columns: list[FloatArray]) -> FloatArray:
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
