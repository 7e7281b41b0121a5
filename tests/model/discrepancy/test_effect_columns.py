"""An effect's columns are derivatives of what the model predicts, free shapes included."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model.effects import catalogue
from model.effects.conformance import plausible
from model.identification.likelihood.form_error import effect_columns
from model.identification.likelihood.linearisation import linearise
from model.identification.likelihood.model_state import Found
from tests.model.discrepancy.sessions import Case, Extras, base_fit

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
