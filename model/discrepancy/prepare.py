"""Prepare measurements for the search, or report why that is impossible."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy.at_rest.varied import Varied
from model.discrepancy.thresholds import (
    LONGEST_CURVE_RATIO,
    MOST_EFFECTS,
    SHORTEST_CURVE_RATIO,
    STIFFNESS_PRIOR_LN,
)
from model.discrepancy.verdict.result import Next
from model.identification.base_model import (
    BaseOptions,
    bases_of,
    not_weighed,
    usual_stiffness,
    weighs,
)
from model.identification.data.data_vector import DataVector, data_vector_of
from model.identification.data.zero_voltage import offset_note
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.linearisation import Bases, FurtherColumns, sensitivities
from model.identification.likelihood.mixed_model_fit import FitProblem
from model.identification.likelihood.model_state import Found
from model.identification.likelihood.noise.row_noise import noise_of
from model.identification.observations import Observed, not_driven, observe
from model.identification.starting_values import rest_field, start
from model.measurements import (
    FloatArray,
    Measurements,
    ModelError,
    RigScale,
    SheetGeometry,
    geometry_difference,
    is_at,
)
from model.measurements.known_arguments import known_arguments
from model.sheet.applied_effects import effect_of
from model.sheet.sheet_model import SheetModel


@known_arguments
@dataclass(frozen=True, kw_only=True)
class DiagnoseOptions:
    """Options of `diagnose`; the defaults look for all that the catalogue has."""

    symmetric: bool = False  # one |EIBM| for both polarities
    # positions to leave out of the fit: (configuration or "" for all, position in m)
    hold_out: tuple[tuple[str, float], ...] = ()
    calibrate: int = 0  # sessions simulated with the base model, from which the threshold comes
    seed: int = 0  # of these
    exclude: tuple[str, ...] = ()  # effects that are not to be considered
    model: SheetModel | None = None  # whose effects are taken as known
    most_effects: int = MOST_EFFECTS  # more take longer
    stiffness_Nm2: float | None = None  # B of configurations without forces; None: a usual one
    promised: tuple[Next, ...] = ()  # proposals whose measurements the data hold


@dataclass(frozen=True)
class Prepared:
    """Ready to be searched."""

    problem: FitProblem
    theta: FloatArray
    found: tuple[Found, ...]
    notes: tuple[str, ...]


def prepare(
    measurements: Measurements, options: DiagnoseOptions, varied: Sequence[Varied] = ()
) -> Prepared:
    """Return everything usable; a `ModelError` where not even the base model can be fitted.

    `varied`: the same measurements less other dynamics.
    """
    used = _kept(measurements, options.hold_out)
    names = [n for n in used.sheets if any(c.configuration == n for c in used.conditions)]
    if not names:
        raise ModelError(
            "there are no measurements: no condition of any configuration of the sheet"
        )
    notes, why, data_vectors, rests, kept, observed = [], [], [], [], [], list[Observed]()
    for name in names:
        try:
            one = data_vector_of(used, name)
            _check_curves(one)
            seen = observe(used, name)
            rests.append(rest_field(one.sheet, seen))
        except ModelError as error:
            why.append(str(error))
            continue
        data_vectors.append(one)
        observed.append(seen)
        kept.append(name)
    if not data_vectors:
        raise ModelError("; ".join(dict.fromkeys(why)))
    notes += [f"left out: {sentence}" for sentence in why]
    notes += _lacks(measurements, data_vectors, options)
    notes += offset_note(used)
    known = [stated for _, stated in rests]
    forward = ForwardModel(data_vectors, [rest for rest, _ in rests])
    base = BaseOptions(symmetric=options.symmetric, stiffness_Nm2=options.stiffness_Nm2)
    bases = bases_of(forward, known, base)
    theta = start(observed, forward, bases, known)
    bases = _anchored(forward, bases, theta)
    if options.model is not None:
        for one in data_vectors:
            sheet = options.model.sheet(one.sheet.configuration).sheet
            check_geometry(one.sheet, sheet)
    if varied:
        bases = _with_dynamics(forward, bases, theta, varied, options.hold_out)
        theta = np.append(theta, np.zeros(bases.size - len(theta)))
    problem = FitProblem.of(forward, bases, noise_of(forward))
    return Prepared(problem, theta, _active(options.model, kept, forward.scale), tuple(notes))


def _with_dynamics(
    forward: ForwardModel,
    bases: Bases,
    theta: FloatArray,
    varied: Sequence[Varied],
    hold_out: tuple[tuple[str, float], ...],
) -> Bases:
    """Return the base models with what changes where the dynamics are not quite those stated."""
    _, residual, _ = sensitivities(forward, bases, theta)
    rests = [configuration_model.rest for configuration_model in forward.configuration_models]
    rows, places, size = list[FloatArray](), list[int](), bases.size
    zero, step = list[float](), list[float]()
    eibm, stiffness = dict[int, FloatArray](), dict[int, FloatArray]()
    for one in varied:
        how = one.step
        if how.configuration not in forward.names:
            continue
        c = forward.names.index(how.configuration)
        part = bases.parts[c]
        data = _kept(one.measurements, hold_out)
        data_vectors = [data_vector_of(data, name) for name in forward.names]
        _, other, _ = sensitivities(ForwardModel(data_vectors, rests, like=forward), bases, theta)
        if how.of == "place":  # no parameter: effects and set-ups move the contacts
            forward.in_motion[c] = (residual - other) / how.size
            continue
        rows.append(residual - other)
        if how.of == "unsure":
            place, value, change, size = size, 0.0, 1.0, size + 1
        elif how.of == "stiffness":
            place, value, change = part.stiffness, float(np.log(how.value)), how.size
        else:
            place, sign = part.eibm[how.voltage_V]
            value, change = sign * how.value, sign * how.value * how.size
        if how.of == "eibm":
            eibm[c] = eibm.get(c, np.zeros(len(residual))) + rows[-1] / how.size
        elif how.of == "stiffness":
            stiffness[c] = rows[-1] / how.size
        places.append(place)
        zero.append(value)
        step.append(change)
    if not rows:  # of configurations that were left out, or of the contacts' places alone
        return bases
    further = FurtherColumns(
        rows=np.stack(rows, axis=1), places=tuple(places), zero=np.array(zero),
        step=np.array(step), own=range(bases.size, size),
        eibm=eibm, stiffness={c: stiffer - eibm[c] for c, stiffer in stiffness.items()},
    )  # fmt: skip
    return replace(bases, size=size, further=further)


def _anchored(forward: ForwardModel, bases: Bases, theta: FloatArray) -> Bases:
    """Return the base models with B kept near its value from (2), where there are curves.

    A base model that is millimetres off would otherwise compensate its misfit under voltage by B,
    and explain the forces at 0 V by a wandering zero.
    """
    parts = []
    for configuration_model, one in zip(forward.configuration_models, bases.parts, strict=True):
        near = {one.stiffness: (float(theta[one.stiffness]), STIFFNESS_PRIOR_LN)}
        parts.append(
            replace(one, prior=near | one.prior) if configuration_model.has_curve.any() else one
        )
    return replace(bases, parts=tuple(parts))


def _check_curves(one: DataVector) -> None:
    """Raise a `ModelError` where a curve has another size than the sheet."""
    whole = one.sheet.free_length_m + one.sheet.elongation_m
    for seen in one.seen:
        if seen.curve is None:
            continue
        length = float(seen.curve.s_m[-1])
        if (
            not SHORTEST_CURVE_RATIO * one.sheet.free_length_m
            < length
            < LONGEST_CURVE_RATIO * whole
        ):
            raise ModelError(
                f"the curve of condition {seen.name} is {length * 1e3:.3g} mm long, the sheet"
                f" {whole * 1e3:.3g} mm; check that x, y and s are in mm"
            )


def _lacks(
    measurements: Measurements, data_vectors: list[DataVector], options: DiagnoseOptions
) -> list[str]:
    """Return messages about questions that these data cannot answer."""
    notes = []
    for one in data_vectors:
        name, seen = one.sheet.configuration, [s for s in one.seen if not s.zero]
        if not one.voltages_V:
            raise ModelError(f"{not_driven(measurements, name)}, or leave it out")
        if not any(s.curve is not None for s in seen):
            notes.append(
                f"'{name}' has no curves: where along the sheet something is missing cannot be seen"
            )
        if not weighs(one):
            notes.append(not_weighed(name, options.stiffness_Nm2 or usual_stiffness(one.sheet)))
        elif 0.0 not in {s.voltage_V for s in seen}:
            notes.append(f"'{name}' was not measured at 0 V: B rests on the driven readings alone")
        if len(one.voltages_V) < 2:
            notes.append(
                f"'{name}' was driven at one voltage: what changes sign with it cannot be told from"
                " what does not"
            )
        if any(s.identical for s in seen):
            notes.append(
                f"repeated readings of '{name}' are identical: they are taken as one reading each,"
                " and its noise from the misfit"
            )
        if not any(len(s.kept_N) > 1 for s in seen) and not one.pulses:
            notes.append(
                f"'{name}' has no two readings of a condition in their order, and no series within"
                " a pulse: what happens in time cannot be seen"
            )
    return notes


def _active(model: SheetModel | None, names: list[str], scale: RigScale) -> tuple[Found, ...]:
    """Return the effects that a model has already, to be refined with the rest."""
    if model is None:
        return ()
    result = []
    for one in model.effects:
        entry = effect_of(one).at_scale(scale)
        acts = [name for name in names if one.values(name) is not None]
        shared = {k.name: k.unstated for k in entry.parameters}
        values = {
            name: {**shared, **{k: v for k, v in (one.values(name) or {}).items() if k in shared}}
            for name in acts
        }
        # without terms its form is the catalogue's, which is no more exact here than elsewhere
        result.append(Found(effect=entry, values=values, given=one.terms or None))
    return tuple(result)


def _kept(measurements: Measurements, hold_out: tuple[tuple[str, float], ...]) -> Measurements:
    """Return the data to fit: all except those held out, each of which was measured."""
    kept, series = measurements.conditions, measurements.series
    for name, at in hold_out:
        if not any(is_at(c, name, at) for c in measurements.conditions):
            where = f"{f'{name}, ' if name else ''}{at * 1e3:g} mm"
            raise ModelError(f"nothing was measured at the position to be held out ({where})")
        kept = tuple(c for c in kept if not is_at(c, name, at))
        series = tuple(s for s in series if not is_at(s, name, at))
    return replace(measurements, conditions=kept, series=series)


def setups(prepared: Prepared) -> int:
    """Return how often the load cell was set, which is the number of set-ups."""
    return prepared.problem.forward.row_index.setups


def sessions(measurements: Measurements) -> int:
    """Return how many sessions are analysed together."""
    return max((c.session for c in measurements.conditions), default=1)


def check_geometry(sheet: SheetGeometry, other: SheetGeometry) -> None:
    """Raise a `ModelError` where the model was fitted to another sheet than this one."""
    unlike = geometry_difference(sheet, other)
    if unlike is not None:
        raise ModelError(
            f"the model was fitted to a '{sheet.configuration}' with a {unlike.measure} of"
            f" {unlike.second}, these data are of one with {unlike.first}"
        )
