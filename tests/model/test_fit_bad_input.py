"""Data that cannot be fitted end in one clear sentence, never in a wrong number."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model import Curve, FitOptions, Measurements, ModelError, fit
from model.identification.likelihood.noise.row_covariance import RowCovariance


def changed(data: Measurements, index: int, **fields: object) -> Measurements:
    conditions = list(data.conditions)
    conditions[index] = replace(conditions[index], **fields)
    return replace(data, conditions=tuple(conditions))


def with_sheet(data: Measurements, **fields: object) -> Measurements:
    return replace(data, sheets={n: replace(s, **fields) for n, s in data.sheets.items()})


@pytest.fixture(scope="module")
def data(measure) -> Measurements:
    return measure(names=("long",))


def curve(data: Measurements, **fields: object) -> Curve:
    found = data.conditions[4].curve
    assert found is not None
    return replace(found, **fields)


def test_nothing_measured(data):
    with pytest.raises(ModelError, match="no measurements"):
        fit(replace(data, conditions=()))


def test_unknown_configuration(data):
    with pytest.raises(ModelError, match=r"no configuration 'wide' \(known: long\)"):
        fit(data, FitOptions(configurations=("wide",)))


def test_a_sheet_that_was_never_under_voltage(data):
    still = tuple(c for c in data.conditions if c.voltage_V == 0.0)
    with pytest.raises(ModelError, match="'long' was measured at 0 V alone"):
        fit(replace(data, conditions=still))


def test_readings_under_voltage_that_do_not_count_are_not_called_unmeasured(data):
    def spoilt(reading):
        return replace(reading, valid=False, why="the drive reads back 0.2 V instead of 2 V")

    conditions = tuple(
        c if c.voltage_V == 0.0 else replace(c, readings=tuple(map(spoilt, c.readings)))
        for c in data.conditions
    )
    with pytest.raises(
        ModelError, match=r"'long' under voltage counts .*reads back 0\.2 V instead"
    ):
        fit(replace(data, conditions=conditions))


def test_a_force_that_is_not_a_number(data):
    readings = list(data.conditions[4].readings)
    readings[3] = replace(readings[3], force_N=np.nan)
    with pytest.raises(ModelError, match=r"long, 5 mm, \+2 V is not a finite number"):
        fit(changed(data, 4, readings=tuple(readings)))


def test_a_curve_with_a_hole(data):
    x = curve(data).x_m.copy()
    x[7] = np.inf
    with pytest.raises(ModelError, match="holds a number that is not finite"):
        fit(changed(data, 4, curve=curve(data, x_m=x)))


def test_a_curve_whose_s_does_not_ascend(data):
    s = curve(data).s_m.copy()
    s[5] = s[8]
    with pytest.raises(ModelError, match="s must ascend"):
        fit(changed(data, 4, curve=curve(data, s_m=s)))


def test_a_curve_of_unequal_columns(data):
    with pytest.raises(ModelError, match="unequal numbers"):
        fit(changed(data, 4, curve=curve(data, y_m=curve(data).y_m[:-1])))


def test_a_curve_of_two_points(data):
    short = Curve(**{name: np.array([0.0, 0.01]) for name in ("s_m", "x_m", "y_m")})
    with pytest.raises(ModelError, match="at least 4"):
        fit(changed(data, 4, curve=short))


def test_a_curve_in_another_unit_has_no_points_on_the_sheet(data):
    far = {name: 1e3 * getattr(curve(data), name) for name in ("s_m", "x_m", "y_m")}
    said = r"long, 5 mm, \+2 V has 1 point on the sheet.* 50 mm long.* unit"
    with pytest.raises(ModelError, match=said):
        fit(changed(data, 4, curve=curve(data, **far)))


@pytest.mark.parametrize("position", [np.nan, 0.2, -0.3])
def test_a_position_off_the_arc(data, position):
    with pytest.raises(ModelError, match="not on the arc"):
        fit(changed(data, 4, position_m=position))


def test_all_readings_invalid_is_said_with_the_reason(data):
    conditions = tuple(
        replace(c, readings=tuple(replace(r, valid=False, why="stuck") for r in c.readings))
        for c in data.conditions
    )
    with pytest.raises(ModelError, match=r"no valid readings at all \(stuck\)"):
        fit(replace(data, conditions=conditions))


@pytest.mark.slow
def test_invalid_conditions_are_left_out_and_noted(measure):
    data = measure(names=("short",))
    last = data.conditions[-1]
    bad = tuple(replace(r, valid=False, why="the sheet stuck in the rolls") for r in last.readings)
    found = fit(changed(data, len(data.conditions) - 1, readings=bad))
    assert len(found.residuals) == 20
    assert "short, 30 mm, -2 V was left out: the sheet stuck in the rolls" in found.notes


@pytest.mark.slow
def test_voltages_of_a_position_that_is_left_out_share_a_sentence(measure):
    data = measure(names=("short",))
    conditions = tuple(
        replace(c, readings=tuple(replace(r, valid=False, why="a bubble") for r in c.readings))
        if c.position_m == 0.01
        else c
        for c in data.conditions
    )
    found = fit(replace(data, conditions=conditions))
    told = [note for note in found.notes if "left out" in note]
    assert told == ["short, 10 mm, 0 V, +2 V, -2 V was left out: a bubble"]


def test_all_positions_held_out_are_said_to_be(data):
    every = {(c.configuration, c.position_m) for c in data.conditions}
    with pytest.raises(ModelError, match="every condition is held out"):
        fit(data, FitOptions(held_out=tuple(every)))


def test_fewer_conditions_than_parameters(data):
    with pytest.raises(ModelError, match=r"need 3 forces"):
        fit(replace(data, conditions=data.conditions[1:3]))


@pytest.mark.slow
def test_shapes_without_forces_do_not_give_a_stiffness(measure):
    data = measure(names=("long",), positions_mm=(), free=True)
    found = fit(data)
    assert not found.configurations["long"].B_known
    assert found.to_json()["configurations"]["long"]["B_Nm2"] is None


@pytest.mark.slow
def test_forces_of_the_wrong_sign(data):
    conditions = tuple(
        replace(c, readings=tuple(replace(r, force_N=-r.force_N) for r in c.readings))
        for c in data.conditions
    )
    with pytest.raises(ModelError, match="opposite sign"):
        fit(replace(data, conditions=conditions))


def test_an_initial_curvature_that_makes_a_loop(data):
    loop = (np.zeros(1), np.array([24000.0]))
    with pytest.raises(ModelError, match=r"makes the sheet a loop .* check its unit"):
        fit(with_sheet(data, initial_curvature=loop))


def test_an_initial_curvature_to_be_measured_without_curves(measure):
    data = measure(names=("long",), curves=False)
    with pytest.raises(ModelError, match="no curve at 0 V"):
        fit(with_sheet(data, initial_curvature=None))


@pytest.mark.parametrize("name", ["free_length_m", "width_m", "thickness_m", "arc_radius_m"])
def test_a_geometry_that_is_not_positive(data, name):
    with pytest.raises(ModelError, match="must be positive"):
        fit(with_sheet(data, **{name: 0.0}))


def test_a_sheet_too_short_for_the_arc(data):
    with pytest.raises(ModelError, match="cannot reach the arc"):
        fit(with_sheet(data, free_length_m=0.03))


@pytest.mark.parametrize(
    "fields",
    [{"weight_exponent": -1.0}, {"initial_curvature_sigma_per_m": -1.0}, {"bootstrap": -1}],
)
def test_meaningless_options(fields):
    with pytest.raises(ModelError, match=r"must not be negative|a number from 0 is needed"):
        FitOptions(**fields)


def test_a_fit_that_ends_far_beside_the_data_is_a_sentence(data, monkeypatch):
    def ends(*_given):
        raise np.linalg.LinAlgError("a covariance is not positive")

    monkeypatch.setattr(RowCovariance, "of", ends)
    with pytest.raises(ModelError, match="no fit of 'long' was found: the model stays far from"):
        fit(data)


def test_a_misfit_that_a_fit_takes_for_scatter_is_told(data, monkeypatch):
    said = "the EIBM would differ from one set-up to the next by 183 %: the fit does not describe"
    assert not any("would differ" in note for note in fit(data).notes)
    found = {"stiffness": 0.01, "eibm": 1.83}
    monkeypatch.setattr("model.identification.joint.Joint.scatter", lambda _self: found)
    assert [note for note in fit(data).notes if note.startswith(said)]
