"""The data about a point of the base parameters: residuals, and derivatives by them.

The point may include what each set-up most likely added (`mounting`): derivatives are then those
where the set-ups really are, and the residuals those of nominal set-ups.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from model.effects.interface import BeamProblem
from model.identification.data.data_vector import Index
from model.identification.likelihood.common_errors.camera_calibration import CalibrationErrors
from model.identification.likelihood.common_errors.drive_rise import RISE, rise_columns
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.model_state import (
    AppliedEffect,
    ModelState,
    Mounting,
)
from model.identification.likelihood.noise.row_covariance import Data
from model.identification.likelihood.noise.row_noise import RowNoise, scatter_precision
from model.identification.likelihood.random_effects import (
    EACH,
    Added,
    Columns,
    groups_of,
    mountings,
    own_eibm,
    restored,
    scatter_columns,
)
from model.identification.priors.shared_widths import SharedWidth
from model.locations.quantities import Perturbation
from model.measurements import FloatArray

WIDE_LN_B, WIDE_EIBM_PER_M = 1e3, 300.0  # prior widths of the base parameters


@dataclass(frozen=True, kw_only=True)
class AtZero:
    """The EIBM of a voltage that reaches the sheet while 0 V is asked for.

    A voltage that stays does not bend the sheet by exactly its share of what a pulse does: it
    charges fully, relaxes back, and finds the water where it was. `more` is what that changes.
    """

    eibm: int  # first place of the EIBM that it is a share of
    share: float
    more: int  # place of the relative change of that share

    def acting_share(self, theta: FloatArray) -> float:
        """Return the share of that EIBM that acts."""
        return float(self.share * (1.0 + theta[self.more]))


@dataclass(frozen=True, kw_only=True)
class BaseParameters:
    """Base parameters of one configuration in the vector of all."""

    stiffness: int
    eibm: dict[float, tuple[int, float]]  # voltage -> first of its places, sign
    forms: FloatArray  # (T, G) of Me/B along the sheet by each of the T places of a voltage
    rest: dict[int, FloatArray]  # place -> change of k0 at the nodes by it
    prior: dict[int, tuple[float, float]]  # place -> mean, width
    at_zero: AtZero | None = None  # what acts while 0 V is asked for

    def drives(self, theta: FloatArray) -> dict[float, tuple[int, float]]:
        """Return the places of the EIBM at all voltages, and how much of it acts; 0 V among them.

        At 0 V that is what an offset of the amplifier does, as it was read back.
        """
        zero = self.at_zero
        return self.eibm | ({} if zero is None else {0.0: (zero.eibm, zero.acting_share(theta))})


@dataclass(frozen=True, kw_only=True)
class FurtherColumns:
    """What all rows change by with base parameters, beyond what the beam problem says; linear.

    Parameters of its own are known only so well: each is in units of its standard deviation.
    """

    rows: FloatArray  # (N, q) change by a step
    places: tuple[int, ...]  # (q,) of the parameters
    zero: FloatArray  # (q,) values at which there is no change
    step: FloatArray  # (q,)
    own: range  # places of parameters that are nothing else
    # by configuration: (N,) by a relative change of a set-up's EIBM, and of its stiffness
    eibm: Mapping[int, FloatArray] = field(default_factory=dict)
    stiffness: Mapping[int, FloatArray] = field(default_factory=dict)

    def columns(self, size: int) -> FloatArray:
        """Return the derivatives by all base parameters, (N, size)."""
        result = np.zeros((len(self.rows), size))
        for place, row in zip(self.places, (self.rows / self.step).T, strict=True):
            result[:, place] += row
        return result

    def at(self, theta: FloatArray) -> FloatArray:
        """Return the change of all rows at base parameters, (N,)."""
        much = (theta[list(self.places)] - self.zero) / self.step
        return np.asarray(self.rows @ much)

    def of_rows(self, count: int) -> FurtherColumns:
        """Return the same of so many other rows that do not change."""
        return replace(self, rows=np.zeros((count, len(self.places))), eibm={}, stiffness={})

    def scattered(self, forward: ForwardModel, scatter: Columns) -> Columns:
        """Return columns of what differs from set-up to set-up with what they change beyond."""
        found = {name: list(columns) for name, columns in scatter.items()}
        turns = dict.fromkeys(EACH, 0)
        for c, block in enumerate(forward.row_index.blocks):
            if c in self.eibm:
                found["eibm"][c] = found["eibm"][c] + self.eibm[c]
                found["stiffness"][c] = found["stiffness"][c] + self.stiffness[c]
            for k, name in own_eibm(forward, c):
                if c in self.eibm:
                    own = np.where(block.of_condition(k, forward.row_index.size), self.eibm[c], 0.0)
                    found[name][turns[name]] = found[name][turns[name]] + own
                turns[name] += 1
        return found


@dataclass(frozen=True, kw_only=True)
class Bases:
    """Places of all base parameters."""

    parts: tuple[BaseParameters, ...]
    size: int
    rise: int | None = None  # first place of what is not known of all pulses' rise alike
    camera: CalibrationErrors | None = None  # what is not known of its calibration
    further: FurtherColumns | None = None
    shared: tuple[SharedWidth, ...] = ()  # widths that are not those of `parts`

    def beam(self, forward: ForwardModel, c: int, theta: FloatArray) -> BeamProblem:
        """Return the beam problem of the base model of a configuration."""
        one, configuration_model = self.parts[c], forward.configuration_models[c]
        rest = sum(
            (theta[i] * row for i, row in one.rest.items()), np.zeros(configuration_model.count)
        )
        count = len(one.forms)
        drives = one.drives(theta).items()
        eibm = {v: much * theta[i : i + count] @ one.forms for v, (i, much) in drives}
        return configuration_model.beam(float(np.exp(theta[one.stiffness])), eibm, np.asarray(rest))


def base_steps(
    forward: ForwardModel,
    bases: Bases,
    c: int,
    state: ModelState,
    base: BeamProblem,
    theta: FloatArray,
) -> dict[int, Perturbation]:
    """Return the derivatives by the base parameters of a configuration."""
    one = bases.parts[c]
    configuration_model = forward.configuration_models[c]
    G = configuration_model.count
    result = {}
    none = forward.no_step(c)
    by = np.zeros_like(none.beam)
    # what a set-up added multiplies the parameters: derivatives are those of the mean set-up, or
    # those in which it happens to be large would count for more
    by[:, -2] = 1.0 if state.mounting is None else 1.0 / (1.0 + state.mounting.stiffness)
    result[one.stiffness] = replace(none, beam=by)
    for voltage, (first, much) in one.drives(theta).items():
        own = configuration_model.voltage_V == voltage
        shaped = _form(state.beam.eibm[own], base.eibm[own]) * state.beam.soft[own]
        bends = {i: much * form for i, form in enumerate(one.forms, first)}
        if one.at_zero is not None and voltage == 0.0:
            whole = theta[first : first + len(one.forms)] @ one.forms
            bends[one.at_zero.more] = one.at_zero.share * whole
        for i, bend in bends.items():
            by = np.zeros_like(none.beam)
            by[own, :G] = shaped * bend
            if i in result:  # one |EIBM| for both polarities, or an offset at 0 V
                by += result[i].beam
            result[i] = replace(none, beam=by)
    for i, row in one.rest.items():
        by = np.zeros_like(none.beam)
        by[:, :G] = row
        result[i] = replace(none, beam=by)
    return result


def _form(shaped: FloatArray, base: FloatArray) -> FloatArray:
    """Return the EIBM with effects relative to the base model's, along the sheet."""
    there = np.abs(base) > 1e-9
    return np.where(there, shaped / np.where(there, base, 1.0), 1.0)


@dataclass(frozen=True, kw_only=True)
class Linearisation:
    """The data about a point: base parameters and active effects as columns of `data.X`."""

    states: tuple[ModelState, ...]
    residual: FloatArray  # (N,)
    columns: FloatArray  # (N, p)
    data: Data
    # what was once computed at these states, by what it is: see `search.evidence.candidates`
    at_states: dict[Hashable, Any] = field(default_factory=dict, compare=False, repr=False)


def sensitivities(
    forward: ForwardModel,
    bases: Bases,
    theta: FloatArray,
    active: tuple[AppliedEffect, ...] = (),
    mounted: Sequence[Mounting] = (),
) -> tuple[tuple[ModelState, ...], FloatArray, FloatArray]:
    """Return states, residuals (N,) and their derivatives (N, p) by the base parameters."""
    states, residual = list[ModelState](), np.zeros(forward.row_index.size)
    columns = np.zeros((forward.row_index.size, bases.size))
    for c in range(len(forward.names)):
        base = bases.beam(forward, c, theta)
        base = mounted[c].applied(base) if mounted else base
        state = forward.state(c, base, active)
        state = replace(state, mounting=mounted[c]) if mounted else state
        states.append(state)
        residual += state.residual
        steps = base_steps(forward, bases, c, state, base, theta)
        columns[:, list(steps)] += forward.rows_of_each(c, state, list(steps.values())).T
    if bases.camera is not None:
        own = slice(bases.camera.first, bases.camera.places.stop)
        columns[:, own] = sum(bases.camera.rows(forward, c, one) for c, one in enumerate(states))
        residual -= columns[:, own] @ theta[own]
    if bases.rise is not None:
        own = slice(bases.rise, bases.rise + len(RISE))
        columns[:, own] = sum(rise_columns(forward, c, state) for c, state in enumerate(states))
        residual -= columns[:, own] @ theta[own]
    if bases.further is not None:
        columns += bases.further.columns(bases.size)
        residual -= bases.further.at(theta)
    return tuple(states), residual, columns


def linearise(
    forward: ForwardModel,
    bases: Bases,
    noise: RowNoise,
    theta: FloatArray,
    active: tuple[AppliedEffect, ...] = (),
    added: Added | None = None,
) -> Linearisation:
    """Return the linearisation about a point; `added` holds each set-up's random effects."""
    mounted = mountings(forward, added) if added else ()
    states, residual, columns = sensitivities(forward, bases, theta, active, mounted)
    scatter: Columns = {}
    for c, state in enumerate(states):
        for name, found in scatter_columns(forward, c, state).items():
            scatter.setdefault(name, []).extend(found)
    groups = groups_of(forward, noise.random_effects, scatter, noise.constant)
    solved = dict(zip(noise.random_effects, groups, strict=True))
    if bases.further is not None:
        beyond = bases.further.scattered(forward, scatter)
        groups = groups_of(forward, noise.random_effects, beyond, noise.constant)
    pad, (mean, width) = forward.row_index.pad, priors_of(bases)
    empty = pad(np.ones(forward.row_index.size)) == 0.0
    y = pad(residual)
    if added:
        y = y + restored(solved, added)
    data = Data(
        y=y, X=pad(columns), groups=groups, masks=[pad(m) for m in noise.masks],
        fixed=np.where(empty, 1.0, pad(noise.fixed)), precision=width**-2.0, away=theta - mean,
        scatter_precision=scatter_precision(noise),
    )  # fmt: skip
    return Linearisation(states=states, residual=residual, columns=columns, data=data)


def priors_of(bases: Bases) -> tuple[FloatArray, FloatArray]:
    """Return middle and width of the priors of all base parameters."""
    mean, width = np.array([_prior(bases, i) for i in range(bases.size)]).T
    for one in bases.shared:
        width[list(one.places)] = one.width
    return mean, width


def with_columns(
    forward: ForwardModel, linear: Linearisation, extra: FloatArray,
    precision: FloatArray | float = 1.0,
    away: FloatArray | float = 0.0,
) -> Linearisation:  # fmt: skip
    """More columns (N, q) with Gaussian priors."""
    q = extra.shape[1]
    X = np.concatenate([linear.data.X, forward.row_index.pad(extra)], axis=2)
    data = replace(
        linear.data, X=X,
        precision=np.concatenate([linear.data.precision, np.broadcast_to(precision, q)]),
        away=np.concatenate([linear.data.away, np.broadcast_to(away, q)]),
    )  # fmt: skip
    return replace(linear, columns=np.concatenate([linear.columns, extra], axis=1), data=data)


def with_only(linear: Linearisation, keep: Index) -> Linearisation:
    """Return some of the columns, by number, with their priors."""
    data = linear.data
    data = replace(data, X=data.X[:, :, keep], precision=data.precision[keep], away=data.away[keep])
    return replace(linear, columns=linear.columns[:, keep], data=data)


def _prior(bases: Bases, i: int) -> tuple[float, float]:
    if bases.rise is not None and 0 <= i - bases.rise < len(RISE):
        return RISE[i - bases.rise]
    if bases.camera is not None and i in bases.camera.places:
        return 0.0, bases.camera.sigma[i - bases.camera.first]
    if bases.further is not None and i in bases.further.own:
        return 0.0, 1.0
    for one in bases.parts:
        if i in one.prior:
            return one.prior[i]
        if i == one.stiffness:
            return 0.0, WIDE_LN_B
    return 0.0, WIDE_EIBM_PER_M
