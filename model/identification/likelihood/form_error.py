"""An effect as columns of the model: its amplitude, its parameters, how its form may differ.

In the search the deviations of a form are linear. In a model that is written they are terms of the
form (`FormWay`), act as in every prediction, and their columns are derivatives by their sizes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model.effects.interface import BeamProblem, EffectParameter
from model.identification.likelihood.form_ways import WayColumn, ways_of
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.linearisation import Linearisation
from model.identification.likelihood.model_state import (
    AppliedEffect,
    FormWay,
    Found,
    ModelState,
    acting_in,
    prior_of,
)
from model.locations.quantities import Perturbation
from model.measurements import FloatArray
from model.sheet.effect_hooks import applied
from model.sheet.form import scaled

WAY_STEP = 0.1


def whole_step(
    forward: ForwardModel,
    c: int,
    state: ModelState,
    base: BeamProblem,
    others: tuple[AppliedEffect, ...],
    one: AppliedEffect,
) -> Perturbation:
    """Return the first-order perturbation by an effect at its present values, given the others."""
    without = shaped(base, state, others, forward.names[c])
    (here,) = acting_in((one,), forward.names[c])
    full = applied(without, state.solved.contact, [here])
    step = replace(
        forward.no_step(c),
        beam=forward.configuration_models[c].change(without, full, state.solved.contact),
    )
    return forward.outer_step(c, state, here, step)


def shaped(
    base: BeamProblem, state: ModelState, active: tuple[AppliedEffect, ...], name: str
) -> BeamProblem:
    """Return the base problem with effects applied, at a known solution."""
    return applied(base, state.solved.contact, acting_in(active, name))


def effect_columns(
    forward: ForwardModel,
    linear: Linearisation,
    one: Found,
    active: tuple[AppliedEffect, ...],
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Columns of an effect in the model, its parameters, then the tolerance of its form: (N, q).

    With precision (q,) and distance (q,) of the present values from the middle of their priors.
    """
    columns, precision, away = list[FloatArray](), list[float](), list[float]()
    places = {name: c for c, name in enumerate(forward.names)}
    bent = [state.base for state in linear.states]
    for parameter, names in one.parameters():
        column = np.zeros(forward.row_index.size)
        for name in names:
            column += _by_parameter(
                forward, places[name], linear, bent[places[name]], one, active, parameter
            )
        value = one.values[names[0]][parameter.name]
        columns.append(column)
        width, away_from_usual = prior_of(parameter, value, one)
        precision.append(width**-2.0)
        away.append(away_from_usual)
    extra, more, off = _form_columns(forward, linear, one, active)
    return (
        np.concatenate(
            [np.zeros((forward.row_index.size, 0)), *(c[:, None] for c in columns), extra], axis=1
        ),
        np.array([*precision, *more]), np.array([*away, *off]),
    )  # fmt: skip


def _form_columns(
    forward: ForwardModel, linear: Linearisation, one: Found, active: tuple[AppliedEffect, ...]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the columns of the tolerance of a form, with precision and distance from no deviation.

    Ways in which the form is inferred to differ come first, and then those that no model has.
    """
    if one.given is not None and not one.ways:
        return np.zeros((forward.row_index.size, 0)), np.zeros(0), np.zeros(0)
    steps = _steps(forward, linear, one, active)
    whole, ways = _deviating(forward, linear, one, steps)
    if not one.ways:
        return _stacked(forward, [w.rows for w in ways]), np.ones(len(ways)), np.zeros(len(ways))
    of_runs = [w.rows for w in ways if not any(terms() for terms in w.terms.values())]
    rows = [_by_way(forward, linear, one, active, i, whole) for i in range(len(one.ways))]
    none = np.zeros(len(of_runs))
    return (
        _stacked(forward, [*rows, *of_runs]),
        np.array([*(way.sigma**-2.0 for way in one.ways), *(none + 1.0)]),
        np.array([*(way.size for way in one.ways), *none]),
    )  # fmt: skip


def _steps(
    forward: ForwardModel, linear: Linearisation, one: Found, active: tuple[AppliedEffect, ...]
) -> list[Perturbation]:
    """Return the perturbation by the effect in each configuration."""
    others, own = tuple(a for a in active if a.effect is not one.effect), one.active
    return [
        whole_step(forward, c, linear.states[c], linear.states[c].base, others, own)
        if name in one.values else forward.no_step(c)
        for c, name in enumerate(forward.names)
    ]  # fmt: skip


def _deviating(
    forward: ForwardModel, linear: Linearisation, one: Found, steps: list[Perturbation]
) -> tuple[list[FloatArray], list[WayColumn]]:
    """Return the rows of each configuration's step, and the ways in which its form may differ.

    Not those in the sizes of configurations, where each has its own: that is a parameter already.
    """
    whole, ways = ways_of(forward, linear.states, one.effect, steps)
    own_sizes = one.effect.by_configuration and len(steps) > 1
    return whole, [w for w in ways if not (own_sizes and w.between_sheets)]


def _stacked(forward: ForwardModel, rows: list[FloatArray]) -> FloatArray:
    return np.stack(rows, axis=1) if rows else np.zeros((forward.row_index.size, 0))


def _by_way(
    forward: ForwardModel, linear: Linearisation, one: Found, active: tuple[AppliedEffect, ...],
    index: int, whole: list[FloatArray],
) -> FloatArray:  # fmt: skip
    """Return the derivative of the rows by the size of a way: a form acts in proportion to it."""
    way = one.ways[index]
    more = replace(way, size=way.size + WAY_STEP)
    turned = replace(one, ways=(*one.ways[:index], more, *one.ways[index + 1 :]))
    steps = _steps(forward, linear, turned, active)
    total = np.zeros(forward.row_index.size)
    for c, (step, before) in enumerate(zip(steps, whole, strict=True)):
        total += forward.rows_of(c, linear.states[c], step) - before
    return total / WAY_STEP


def formed(forward: ForwardModel, linear: Linearisation, one: Found, sizes: FloatArray) -> Found:
    """Return an effect with the deviations of its form in it, of these sizes (J,).

    `sizes` are those of its columns beyond the parameters, in which they were linear.
    """
    steps = _steps(forward, linear, one, (one.active,))
    _, deviating = _deviating(forward, linear, one, steps)
    ways = []
    for way, size in zip(deviating, sizes.tolist(), strict=True):
        terms = tuple(
            replace(scaled(term, way.share), configurations=(name,))
            for name, made in way.terms.items() for term in made()
        )  # fmt: skip
        if terms:
            ways.append(FormWay(terms=terms, size=size, sigma=1.0))
    return replace(one, ways=tuple(ways))


def _by_parameter(
    forward: ForwardModel, c: int, linear: Linearisation, base: BeamProblem, one: Found,
    active: tuple[AppliedEffect, ...],
    parameter: EffectParameter,
) -> FloatArray:  # fmt: skip
    """Return the derivative of the rows by a parameter, or by its logarithm."""
    name, state = forward.names[c], linear.states[c]
    values, own = dict(one.values[name]), one.active
    value = values[parameter.name]
    h = 0.02 if parameter.log else 0.05 * parameter.prior_scale
    both = []
    for sign in (-1.0, 1.0):
        values[parameter.name] = value * np.exp(sign * h) if parameter.log else value + sign * h
        turned = tuple(
            replace(own, values={name: dict(values)}) if a.effect is one.effect else a
            for a in active
        )
        beam = shaped(base, state, turned, name)
        (here,) = acting_in((replace(own, values={name: dict(values)}),), name)
        outer = forward.outer_step(c, state, here, forward.no_step(c))
        both.append((beam, outer))
    (low, outer_low), (high, outer_high) = both
    # what is outside of the beam problem bends free shapes and late images, too
    change = forward.configuration_models[c].change(low, high, state.solved.contact)
    step = replace(outer_high, beam=outer_high.beam + change)
    rows = forward.rows_of(c, state, step) - forward.rows_of(c, state, outer_low)
    result: FloatArray = rows / (2.0 * h)
    return result
