"""Random effects between set-ups: columns by which each run may differ on its own.

Packed as in `mixed_model`: each random effect has a matrix Z (R, n, q), the rows of R runs by q
numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from model.effects.rise import rise_left
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.model_state import ModelState, Mounting
from model.locations.quantities import Perturbation
from model.measurements import FloatArray, RigScale

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
# which of them are lengths or forces, and in proportion to those of a session
UNITS = {
    "position": "m", "registration": "m", "force_zero": "mN", "sway_slow": "mN",
    "sway_quick": "mN", "pulse_level": "mN",
}  # fmt: skip
WANDER_S = {"sway_slow": 40.0, "sway_quick": 3.0}  # correlation times
PULSES = ("pulse_level", "pulse_edge")
EACH = ("eibm_condition", "eibm_free")  # of which each condition has its own
# those that change the beam problem, so that the model can be solved where they are
IN_THE_BEAM = ("stiffness", "eibm", "position", "clamp_tilt", *EACH)
Columns = dict[str, list[FloatArray]]  # by scatter: columns (N,)
Added = Mapping[str, FloatArray]  # by scatter: what each run's set-up added, (R, q)


@dataclass(frozen=True, kw_only=True)
class NoisePriors:
    """Prior sizes of scatter and noise, before they are fitted."""

    # standard deviation of each random effect, and that of its logarithm
    random_effects: Mapping[str, tuple[float, float]]
    curve_unsure: float  # of the logarithm of the curves' noise, common to all modes
    mode_unsure: float  # of each mode's beside that
    # noise of a condition's mean force beside that of its readings; 0: a misfit is not noise
    misfit_N: float = 0.0
    misfit_unsure: float = 0.0  # of its logarithm

    def at_scale(self, scale: RigScale) -> NoisePriors:
        """Return those of a session of another size."""
        sizes = {
            name: (size * scale.of_unit(UNITS.get(name, "")), unsure)
            for name, (size, unsure) in self.random_effects.items()
        }
        return replace(self, random_effects=sizes, misfit_N=self.misfit_N * scale.force)


# A diagnosis tells effects from scatter by how large scatter usually is.
USUAL = NoisePriors(random_effects=ASSUMED, curve_unsure=0.0, mode_unsure=1.5)
UNSURE = 2.5
# A fit takes scatter and misfit as the data have them; means know no course in time. Few curves say
# little of the noise of one mode: modes are as noisy as the curves are, but for a factor of two.
WIDE = NoisePriors(
    random_effects={
        name: (size, UNSURE)
        for name, (size, _) in ASSUMED.items()
        if name not in (*WANDER_S, *PULSES)
    },
    curve_unsure=UNSURE,
    mode_unsure=0.7,
    misfit_N=2e-5,
    misfit_unsure=UNSURE,
)  # fmt: skip


def scatter_columns(forward: ForwardModel, c: int, state: ModelState) -> Columns:
    """Rows of one configuration by what differs from set-up to set-up, each shared by a run."""
    none = forward.no_step(c)
    block = forward.row_block(c)
    configuration_model = forward.configuration_models[c]
    steps = {name: [step] for name, step in _setup_steps(forward, c, state).items()}
    steps["registration"] = [replace(none, points_m=n) for n in (state.solved.nx, state.solved.ny)]
    rise = max(configuration_model.sheet.rise_time_s, 1e-3)
    late = rise_left(block.bin_clock, rise, block.edge_s) - rise_left(block.bin_clock, rise, 0.0)
    steps["pulse_edge"] = [replace(none, bin_eibm=block.bin_mean(late))]
    steps |= {name: [] for name in EACH}
    active = _active(state)
    for k, name in own_eibm(forward, c):
        by = np.zeros_like(none.beam)
        by[k, : configuration_model.count] = active[k]
        steps[name].append(replace(none, beam=by))
    rows = iter(forward.rows_of_each(c, state, [one for own in steps.values() for one in own]))
    return {name: [next(rows) for _ in own] for name, own in steps.items()}


def own_eibm(forward: ForwardModel, c: int) -> list[tuple[int, str]]:
    """Return the conditions that have an EIBM of their own, each with the name of its scatter."""
    configuration_model = forward.configuration_models[c]
    driven = np.flatnonzero(configuration_model.voltage_V).tolist()
    return [(k, "eibm_free" if k in configuration_model.free else "eibm_condition") for k in driven]


def own_slots(forward: ForwardModel) -> list[dict[int, tuple[str, int, int]]]:
    """Return scatter, run and place in the run of the EIBM that a condition has of its own.

    By condition, for each configuration.
    """
    taken: dict[tuple[str, int], int] = {}
    result = []
    for c, data_vector in enumerate(forward.data_vectors):
        slots = {}
        for k, name in own_eibm(forward, c):
            run = forward.row_index.runs.index(data_vector.seen[k].run)
            taken[name, run] = taken.get((name, run), -1) + 1
            slots[k] = (name, run, taken[name, run])
        result.append(slots)
    return result


def mountings(forward: ForwardModel, added: Added) -> list[Mounting]:
    """Return what set-ups added, as the conditions of each configuration have it."""
    result = []
    for data_vector, slots in zip(forward.data_vectors, own_slots(forward), strict=True):
        runs = [forward.row_index.runs.index(one.run) for one in data_vector.seen]
        shared = {
            name: added[name][runs, 0] for name in IN_THE_BEAM if name not in EACH
        }  # fmt: skip
        for k, (name, run, place) in slots.items():
            shared["eibm"][k] += added[name][run, place]
        result.append(
            Mounting(
                stiffness=shared["stiffness"], eibm=shared["eibm"],
                position_m=shared["position"], tilt_rad=shared["clamp_tilt"],
            )
        )  # fmt: skip
    return result


def restored(groups: Mapping[str, FloatArray], added: Added) -> FloatArray:
    """Return what the residuals of the solved set-ups lack of those of nominal ones: (R, n)."""
    return np.asarray(
        sum(np.einsum("rnq,rq->rn", groups[name], added[name]) for name in IN_THE_BEAM)
    )


def _active(state: ModelState) -> FloatArray:
    """Change of k* by a relative change of the EIBM of the nominal set-up: (K, G)."""
    share = 1.0 if state.mounting is None else 1.0 + state.mounting.eibm[:, None]
    return np.asarray(state.beam.eibm * state.beam.soft / share)


def _setup_steps(forward: ForwardModel, c: int, state: ModelState) -> dict[str, Perturbation]:
    """One unit of B, EIBM (relative), position (m), tilt (rad) and the cell's zero (N)."""
    configuration_model, none = forward.configuration_models[c], forward.no_step(c)
    G = configuration_model.count

    def beam(column: int | slice, value: FloatArray | float) -> FloatArray:
        by = np.zeros_like(none.beam)
        by[:, column] = value
        return by

    stiff = (
        np.ones(configuration_model.K) if state.mounting is None else 1.0 + state.mounting.stiffness
    )
    bent = state.beam.eibm * state.beam.soft / stiff[:, None]
    on_arc = beam(2 * G + 1, 1.0) + beam(2 * G + 3, 1.0)
    return {
        "stiffness": replace(none, beam=beam(slice(0, G), -bent) + beam(-2, 1.0 / stiff)),
        "eibm": replace(none, beam=beam(slice(0, G), _active(state))),
        "position": replace(none, beam=on_arc / configuration_model.sheet.arc_radius_m),
        "clamp_tilt": replace(none, beam=beam(-1, 1.0) - on_arc),
        "force_zero": replace(none, force_N=np.ones(len(forward.row_block(c).reading_of))),
    }


def constant_groups(forward: ForwardModel, priors: NoisePriors) -> dict[str, FloatArray]:
    """Return the scatters that are equal for all states: load cell's wander and pulse levels."""
    names = priors.random_effects
    groups = {name: by_run(forward, _wander(forward, name)) for name in WANDER_S if name in names}
    if "pulse_level" in names:
        groups["pulse_level"] = by_run(forward, _pulse_levels(forward))
    return groups


def groups_of(
    forward: ForwardModel,
    names: Iterable[str],
    scatter: Columns,
    constant: Mapping[str, FloatArray],
) -> list[FloatArray]:
    """Return the named scatters in order; `scatter` has the columns of all configurations."""
    groups = []
    for name in names:
        if name in constant:
            groups.append(constant[name])
        elif name == "registration":  # to the side and along, of one size
            one = [scatter[name][i::2] for i in (0, 1)]
            groups.append(
                np.concatenate([by_run(forward, [np.sum(o, axis=0)]) for o in one], axis=2)
            )
        elif name in EACH:
            groups.append(_one_each(forward, name, scatter[name]))
        else:
            groups.append(by_run(forward, [np.sum(scatter[name], axis=0)]))
    return groups


def _one_each(forward: ForwardModel, name: str, columns: list[FloatArray]) -> FloatArray:
    """Columns (N,) of the conditions that have an EIBM of their own, packed as (R, n, q)."""
    slots = [slot for own in own_slots(forward) for slot in own.values() if slot[0] == name]
    flat = np.zeros((forward.row_index.size, 1 + max([0, *(place for _, _, place in slots)])))
    for (_, _, place), column in zip(slots, columns, strict=True):
        flat[:, place] += column
    return forward.row_index.pad(flat)


def _wander(forward: ForwardModel, name: str) -> list[FloatArray]:
    """Return columns (N,) of a factor of the covariance of the load cell's wander in a run."""
    columns = []
    for block in forward.row_index.blocks:
        clock = block.clock.run_s
        run = forward.row_index.run_of[block.trend_rows]
        for r in np.unique(run):
            rows = block.trend_rows[run == r]
            T = block.trend[run == r]
            use = np.flatnonzero(np.any(T != 0.0, axis=0))
            apart = np.abs(clock[use][:, None] - clock[use])
            kernel = np.exp(-apart / WANDER_S[name])
            V = T[:, use] @ kernel @ T[:, use].T
            values, vectors = np.linalg.eigh(V)
            for j in np.flatnonzero(values > 1e-6 * max(values[-1], 1e-300)):
                column = np.zeros(forward.row_index.size)
                column[rows] = vectors[:, j] * np.sqrt(values[j])
                columns.append(column)
    return columns


def _pulse_levels(forward: ForwardModel) -> list[FloatArray]:
    """All parts of a pulse share the error of the sampling point's force."""
    columns = []
    for block in forward.row_index.blocks:
        for p in np.unique(block.bin_set):
            column = np.zeros(forward.row_index.size)
            column[block.bin_rows[block.bin_set == p]] = 1.0
            columns.append(column)
    return columns


def by_run(forward: ForwardModel, columns: list[FloatArray]) -> FloatArray:
    """Columns (N,) that touch one run each, or all: packed as (R, n, q)."""
    row_index = forward.row_index
    taken = np.zeros(len(row_index.runs), dtype=np.int64)  # of the columns of each run
    flat = np.zeros((row_index.size, max(1, len(columns))))
    for column in columns:
        rows = np.flatnonzero(column)
        runs = row_index.run_of[rows]
        flat[rows, taken[runs]] = column[rows]
        taken[np.unique(runs)] += 1
    return row_index.pad(flat[:, : max(1, int(np.max(taken)))])
