"""A model file has what was found only where left-out positions are predicted no worse with it."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from model.discrepancy import diagnose
from model.discrepancy.verdict.messages import not_written
from model.discrepancy.verdict.written_model import chosen
from model.discrepancy.verdict.written_model.left_out_gain import predicts_better
from tests.model.discrepancy.sessions import FALLING, base_fit, session


@pytest.mark.slow
def test_what_leaves_the_prediction_as_it_is_may_be_written():
    base = base_fit()
    assert predicts_better(base, base)


@pytest.mark.slow
def test_what_spoils_the_prediction_of_left_out_positions_is_not_written():
    """All data moved by a noise of their own: no parameter can take that up."""
    base = base_fit()
    noise = 1e-4 * np.random.default_rng(1).standard_normal(len(base.linear.residual))
    linear = replace(base.linear, residual=base.linear.residual + noise)
    worse = replace(base, linear=linear)
    assert not predicts_better(base, worse)
    assert predicts_better(worse, base)


@pytest.mark.slow
def test_where_the_base_model_predicts_better_the_file_has_it_and_a_note_says_so(monkeypatch):
    monkeypatch.setattr(chosen, "predicts_better", lambda *_: False)
    found = diagnose(session(FALLING))
    assert [one.name for one in found.effects] == ["nonuniform_eibm"]
    assert found.effects[0].parameters["decay_length_mm"].value > 0.0
    assert found.model.effects == ()
    assert found.held_out.before == found.held_out.after
    assert next(not_written(True)) in found.notes
    json.dumps(found.to_json(), allow_nan=False)
