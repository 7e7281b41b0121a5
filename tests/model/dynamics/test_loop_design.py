"""Designs for the sheets of the examples, and figures of a step."""

from __future__ import annotations

import numpy as np
import pytest

from model.dynamics.linear.linear_model import read_by
from model.dynamics.linear.loop_design import PLANT_STATES, designed, figures_of
from model.dynamics.linear.state_space import balanced
from model.measurements import ModelError
from tests.model.dynamics.sheets import SHORT, beam, model_of

LOOP = {"rate_hz": 200.0, "delay_s": 3e-3, "limit_V": 2.0}


@pytest.fixture(scope="module")
def sheets():
    long, short = beam(), beam(**SHORT)
    return {
        "long, 0 mm": model_of(long, 0.0).output("force_N"),
        "long, 15 mm": model_of(long, 0.015).output("force_N"),
        "short, 5 mm": model_of(short, 0.005).output("force_N"),
    }


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "method", "settled_s"),
    [("long, 0 mm", "lqg", 0.3), ("long, 0 mm", "pi", 0.45), ("long, 15 mm", "lqg", 0.3),
     ("short, 5 mm", "lqg", 0.15), ("short, 5 mm", "pi", 0.2)],
)  # fmt: skip
def test_a_step_of_1_mN_settles_as_fast_as_the_voltage_allows(sheets, name, method, settled_s):
    made = designed(sheets[name], method, **LOOP)
    assert 0.05 < made.step.rise_s < made.step.settled_s <= settled_s
    assert made.sensitivity_peak <= 1.6 * (1 + 1e-9)
    assert made.step.overshoot < 0.15


def test_the_model_of_a_design_is_within_a_thousandth_of_the_static_gain(sheets):
    for sheet in sheets.values():
        reduced, _ = balanced(sheet, PLANT_STATES)
        assert reduced.static_gain == pytest.approx(sheet.static_gain, rel=1e-3)


def test_eight_states_are_within_a_hundredth(sheets):
    reduced, _ = balanced(sheets["long, 0 mm"], 8)
    assert reduced.static_gain == pytest.approx(sheets["long, 0 mm"].static_gain, rel=1e-2)


def test_figures_of_a_step_are_those_of_its_samples():
    share = np.array([0.0, 0.5, 0.95, 1.05, 1.01, 0.99, 1.0])
    found = figures_of(1e-3 * share, 0.01, 1e-3)
    assert (found.rise_s, found.settled_s) == pytest.approx((0.02, 0.04))
    assert found.overshoot == pytest.approx(0.05)


def test_a_force_that_never_arrives_has_no_figures():
    found = figures_of(np.full(10, 5e-4), 0.01, 1e-3)
    assert np.isnan(found.rise_s)
    assert np.isnan(found.settled_s)


def test_a_sheet_that_the_voltage_does_not_move_is_refused(sheets):
    free = model_of(beam(), None).output("force_N")
    with pytest.raises(ModelError, match="nothing can be controlled"):
        designed(free, "pi", **LOOP)


def test_a_load_cell_that_rings_for_ever_is_refused(sheets):
    rings = read_by(sheets["long, 0 mm"], 100.0, 0.0)
    with pytest.raises(ModelError, match="give a load cell with a resonance a damping above 0"):
        designed(rings, "pi", **LOOP)


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"rate_hz": 0.0}, "rate of a loop must be positive and finite, not 0 Hz"),
        ({"limit_V": np.inf}, "voltage limit of a loop must be positive and finite, not inf V"),
        ({"step_N": np.inf}, "step of the force must be finite and not 0, it is inf mN"),
        ({"step_N": 0.0}, "step of the force must be finite and not 0, it is 0 mN"),
    ],
)
def test_a_loop_that_is_none_is_refused_with_what_is_wrong(sheets, wrong, sentence):
    with pytest.raises(ModelError, match=sentence):
        designed(sheets["long, 0 mm"], "pi", **(LOOP | wrong))
