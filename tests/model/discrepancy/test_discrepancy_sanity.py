"""Data in other units, out of reach or of no run are told, not silently fitted or dropped."""

from __future__ import annotations

from dataclasses import replace

import pytest

from model import ModelError
from model.discrepancy.prepare import DiagnoseOptions, prepare
from model.discrepancy.verdict.data_checks import place_or_time, remarks
from tests.model.discrepancy.sessions import base_fit, fitted, of_one_sheet, session


def test_a_usual_session_is_not_remarked_upon():
    assert list(remarks(session(), base_fit())) == []


def test_a_position_out_of_reach_is_named():
    fitted = base_fit()
    state = fitted.linear.states[0]
    far = state.solved.contact.s_hat_m.copy()
    far[-1] = 0.08
    contact = replace(state.solved.contact, s_hat_m=far)
    beyond = replace(state, solved=replace(state.solved, contact=contact))
    linear = replace(fitted.linear, states=(beyond, *fitted.linear.states[1:]))
    (said,) = remarks(session(), replace(fitted, linear=linear))
    assert said.startswith("'long' cannot reach 30 mm in the model")


def test_a_series_where_no_force_was_measured_is_named():
    m = session()
    lost = replace(m.series[0], position_m=0.0075)
    (said,) = remarks(replace(m, series=(*m.series, lost)), base_fit())
    assert said == "the series of 'long' at 7.5 mm is left out: no force was measured there"


def test_curves_in_metres_are_refused():
    m = session()

    def in_metres(c):
        curve = replace(c.curve, s_m=c.curve.s_m / 1e3, x_m=c.curve.x_m / 1e3)
        return replace(c, curve=curve)

    with pytest.raises(ModelError, match=r"long, .* is 0.05 mm long, the sheet 50 mm; check that"):
        prepare(replace(m, conditions=tuple(in_metres(c) for c in m.conditions)), DiagnoseOptions())


def test_a_time_since_wetting_that_is_not_known_is_named():
    m = session()

    def dry(condition):
        unknown = tuple(replace(r, wetted_s=None) for r in condition.readings)
        return replace(condition, readings=unknown)

    unknown = replace(m, conditions=tuple(map(dry, m.conditions)))
    (said,) = remarks(unknown, base_fit())
    assert said.startswith("it is not known when the sheet was moistened")
    assert list(remarks(m, base_fit())) == []


def test_a_sheet_of_which_most_curves_are_missing_is_named():
    """All curves of a sheet may be refused, and 'nothing is missing' rests on its forces alone."""
    m = session()
    lost = [c for c in m.conditions if c.configuration == "long" and c.position_m != 0.0]
    kept = tuple(replace(c, curve=None) if c in lost else c for c in m.conditions)
    (said,) = remarks(replace(m, conditions=kept), base_fit())
    every = sum(c.configuration == "long" for c in m.conditions)
    assert said.startswith(f"'long' has no curve in {len(lost)} of {every} conditions")
    none = tuple(replace(c, curve=None) for c in m.conditions)
    assert list(remarks(replace(m, conditions=none), base_fit())) == []


def test_where_place_and_time_go_together_a_drift_comes_with_a_note():
    """A zero that had stepped was called sticking rolls from a position on, without a word."""
    one = fitted(of_one_sheet(session(), "long"))
    assert list(place_or_time(one, ["gravity"], None)) == []
    (said,) = place_or_time(one, ["gravity", "force_drift"], None)
    assert "what goes with the place may as well go with the time" in said
    assert list(place_or_time(base_fit(), ["force_drift"], None)) == []  # two times at each place
