"""A prediction stands for the mean of the readings to which effects are fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model import SheetModel
from model.identification.data.data_vector import data_vector_of
from model.mechanics import field
from model.mechanics.field import Field
from model.parameter import Parameter
from model.sheet.applied_effects import beam_problem
from model.sheet.beam_problem import ActiveEffect
from model.sheet.solution import free_curvature
from model.sheet.typical_run import typical_run
from tests.model.discrepancy.sessions import means_of, session


@pytest.mark.slow
def test_its_times_are_those_of_data_of_the_papers_protocol():
    seen = [
        one
        for one in data_vector_of(means_of(session()), "long").seen
        if not (one.free or one.zero)
    ]
    assert {one.voltage_V for one in seen} == {2.0, -2.0, 0.0}
    for one in (one for one in seen if one.voltage_V):
        volts, clock = one.voltage_V, one.kept_clock
        ratio = -clock.opposite[0] if volts > 0.0 else -1.0 / clock.opposite[0]
        run = typical_run(volts, -volts, float(clock.rise_s[0]), ratio=float(ratio))
        told = run.clock.of(run.at(volts))
        assert float(ratio) != pytest.approx(1.0)
        for name in ("voltage_V", "pulse", "pulse_s", "run_s", "driven_s", "opposite", "rise_s"):
            assert getattr(told, name) == pytest.approx(getattr(clock, name)), name
    zero = next(one for one in seen if not one.voltage_V).kept_clock
    run = typical_run(0.0, 0.0)
    told = run.clock.of(run.at(0.0))
    for name in ("pulse", "pulse_s", "run_s", "driven_s", "opposite"):
        assert getattr(told, name) == pytest.approx(getattr(zero, name)), name


def test_at_0_V_a_drift_since_the_wetting_has_not_begun(truth: SheetModel):
    values = {"relative_change": 0.2, "since_wetting": 1.0, "settles": 0.0}
    drift = ActiveEffect(
        name="stiffness_drift",
        parameters={name: Parameter(value=v, sigma=0.0, unit="") for name, v in values.items()},
    )
    # B is the stated one in the middle of a run, and the force at 0 V goes with it
    before_N = truth.predict("long", 0.02, 0.0).F_N
    force_N = truth.with_effects(drift).predict("long", 0.02, 0.0).F_N
    assert force_N == pytest.approx(0.9 * before_N, rel=1e-6)


def test_a_condition_knows_how_far_it_comes_from_at_the_other_polarity(truth: SheetModel):
    places = [(0.01, volts) for volts in truth.alternating_voltages_V("long", -2.0)]
    beam = beam_problem(truth.setups("long", places), [0.01] * len(places))
    assert places[0][1] == -2.0
    eibm = {v: float(along.values[0]) for v, along in truth.sheet("long").eibm.items()}
    own = beam.clock.voltage_V == -2.0
    assert beam.clock.opposite[own] == pytest.approx(eibm[2.0] / eibm[-2.0])


def test_a_bend_of_few_panels_is_added_to_a_rest_curvature_of_many(truth: SheetModel, monkeypatch):
    setup = truth.setup("long", 0.01, 2.0)
    length = setup.rest.length_m
    s = np.linspace(0.0, length, 41)
    rest = Field.linear(s, 20.0 + 5.0 * np.sin(90.0 * s), length)
    soft = Field(np.array([0.0, length]), np.array([[1.2, 0.1, -0.05]]))
    asked = []
    real = field._interpolate
    monkeypatch.setattr(field, "_interpolate", lambda *a: asked.append(a) or real(*a))
    found = free_curvature(replace(setup, rest=rest, softness=soft))
    assert len(asked) == 1
    at = np.linspace(0.0, length, 301)
    wanted = rest(at) + setup.eibm(at) * soft(at) / setup.B_Nm2
    assert found(at) == pytest.approx(wanted, rel=1e-12)
