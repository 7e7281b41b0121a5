"""An effect's columns are derivatives of what the model predicts, free shapes included."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model.effects import catalogue
from model.effects.conformance import plausible
from model.identification.likelihood.form_error import effect_columns, whole_step
from model.identification.likelihood.form_ways import ways_of
from model.identification.likelihood.linearisation import linearise
from model.identification.likelihood.model_state import Found
from tests.model.discrepancy.sessions import Case, Extras, base_fit, fitted, session

FREE = Case((), extras=Extras(free_shapes=True), seed=3)


@pytest.mark.parametrize("name", ["eibm_drift", "viscoelastic_creep", "frame_delay", "clamp_angle"])
def test_free_shapes_change_with_a_parameter_as_its_column_says(name: str):
    base = base_fit(FREE)
    problem, forward = base.problem, base.problem.forward
    effect = catalogue()[name]
    size = effect.parameters[0]
    # a column takes the EIBM as changed already, which is of second order
    small = dict(plausible(effect))
    small[size.name] *= 0.05
    values = dict.fromkeys(forward.names, small)
    one = Found(effect=effect, values=values)
    linear = linearise(forward, problem.bases, problem.noise, base.theta, (one.active,))
    column = effect_columns(forward, linear, one, (one.active,))[0][:, 0]
    step = 0.02 * size.prior_scale
    (_, names), *_ = one.parameters()
    differences = np.zeros(len(column))
    for name_of in names:
        c = forward.names.index(name_of)
        low, high = (
            forward.state(c, linear.states[c].base, (_with(one, size.name, name_of, s),)).residual
            for s in (-step, step)
        )
        differences += (low - high) / (2.0 * step)
    rows = _of_free_shapes(forward)
    assert np.linalg.norm(differences[rows]) > 0.0
    miss = np.linalg.norm(column[rows] - differences[rows])
    assert miss < 0.01 * np.linalg.norm(differences[rows])


def _with(one: Found, parameter: str, name: str, more: float):
    own = dict(one.values[name])
    own[parameter] += more
    return replace(one, values={**one.values, name: own}).active


def _of_free_shapes(forward) -> list[int]:
    rows = list[int]()
    for c, of in enumerate(forward.configuration_models):
        for k in of.unread:
            rows += forward.row_block(c).mode_rows[k].tolist()
    return rows


@pytest.mark.parametrize("name", ["charging_lag", "first_pulse_transient"])
def test_a_deviation_goes_with_the_same_in_a_sheet_of_shapes_alone(name: str):
    m = session(FREE)
    shapes = [c for c in m.conditions if c.configuration == "short" or c.position_m is None]
    base = fitted(replace(m, conditions=tuple(shapes), series=()))
    forward, effect = base.problem.forward, catalogue()[name]
    values = dict.fromkeys(forward.names, plausible(effect))
    active = (Found(effect=effect, values=values).active,)
    linear = linearise(forward, base.problem.bases, base.problem.noise, base.theta, active)
    steps = [
        whole_step(forward, c, linear.states[c], linear.states[c].base, (), *active)
        for c in range(len(forward.names))
    ]
    _, ways = ways_of(forward, linear.states, effect, steps)
    assert set(forward.names) == {"long", "short"}
    told = [{one.along for terms in way.terms.values() for one in terms()} for way in ways]
    assert {len(each) for each in told} <= {0, 1}
    assert {"session", "run"} & set().union(*told)
