"""Free shapes that still swing are told and left out, or explained by dynamics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks._moving_dynamics import session, true_model
from model import fit
from model.discrepancy import DiagnoseOptions, check_data, diagnose
from model.discrepancy.at_rest.at_rest import at_rest
from model.identification.data.swinging_shapes import without_swinging
from model.measurements import Measurements

SEED = 31


def swinging() -> Measurements:
    return session(SEED, (), loss="small", free_shapes=1)


def free_voltages(data: Measurements) -> set[float]:
    return {c.voltage_V for c in data.conditions if c.position_m is None}


def spread_m(data: Measurements) -> float:
    """How far apart the ends of the pictures at +2 V are."""
    shape = next(c for c in data.conditions if c.position_m is None and c.voltage_V > 0.0)
    ends = np.array([[r.curve.x_m[-1], r.curve.y_m[-1]] for r in shape.readings])
    return float(np.max(np.ptp(ends, axis=0)))


@pytest.mark.slow
def test_shapes_under_voltage_that_swing_are_told_and_left_out_before_the_search():
    found = check_data(swinging())
    (told,) = [one for one in found.suspicions if one.check == "swinging"]
    assert told.severity == "warn"
    assert "it may still swing" in told.sentence
    assert found.notes == ("free shapes of 'long' under voltage are left out: they still swing",)
    assert free_voltages(found.measurements) == {0.0}
    assert len(found.measurements.series) == len(swinging().series)


@pytest.mark.slow
def test_where_one_voltage_swings_the_other_goes_too_though_its_pictures_agree():
    data = swinging()
    still = tuple(
        replace(c, readings=tuple(replace(r, curve=c.readings[-1].curve) for r in c.readings))
        if c.position_m is None and c.voltage_V < 0.0
        else c
        for c in data.conditions
    )
    assert free_voltages(without_swinging(replace(data, conditions=still))[0]) == {0.0}


@pytest.mark.thorough
@pytest.mark.slow
def test_shapes_at_rest_stay():
    data = session(SEED, (), loss="small", free_shapes=1)
    calm = tuple(
        replace(c, readings=tuple(replace(r, curve=c.readings[-1].curve) for r in c.readings))
        if c.position_m is None
        else c
        for c in data.conditions
    )
    found = check_data(replace(data, conditions=calm))
    assert free_voltages(found.measurements) == {0.0, 2.0, -2.0}
    assert not any("left out" in note for note in found.notes)


@pytest.mark.thorough
@pytest.mark.slow
def test_a_fit_leaves_out_what_swings_and_says_so():
    data = swinging()
    rest = tuple(c for c in data.conditions if c.position_m is not None or not c.voltage_V)
    found, without = fit(data), fit(replace(data, conditions=rest))
    assert "free shapes of 'long' under voltage are left out: they still swing" in found.notes
    assert found.configurations["long"].B.value == without.configurations["long"].B.value


@pytest.mark.thorough
def test_with_dynamics_the_shapes_are_those_at_rest_and_stay():
    data = swinging()
    model = true_model(SEED, {}, data.sheets["long"], "small")
    rested = at_rest(data, model)
    assert rested.dynamics["long"].free_m > 2e-3
    found = check_data(rested.measurements)
    assert not found.suspicions
    assert free_voltages(found.measurements) == {0.0, 2.0, -2.0}
    raw, rest = (spread_m(each) for each in (data, rested.measurements))
    assert raw > 2e-3
    assert rest < 0.1 * raw


@pytest.mark.thorough
def test_with_dynamics_nothing_is_named_where_a_sheet_swings():
    data = session(SEED, (), loss="small", free_shapes=1)
    model = true_model(SEED, {}, data.sheets["long"], "small")
    found = diagnose(data, DiagnoseOptions(model=model))
    assert found.verdict == "nothing_missing"
    assert found.dynamics["long"].free_m > 2e-3
