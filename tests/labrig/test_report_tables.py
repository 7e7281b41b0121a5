"""The paper's tables: this session's numbers are measured ones, the paper's stand beside them."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from labrig.report.data.findings import Findings
from labrig.report.data.fitted import FittedSheets, fit_what_can_be
from labrig.report.data.models import force_curve_N
from labrig.report.data.quality import quality, scatter_and_drift
from labrig.report.data.selection import force_line, mean_force, rest_position_m
from labrig.report.page.summary import cards
from labrig.report.parts.table import fixed, interval, number, with_sigma
from labrig.report.tables.devices import device_row, devices_as_table
from labrig.report.tables.fit import residual_table, scatter_table, trust
from labrig.report.tables.measurements import measurements_as_dict, measurements_tables
from labrig.report.tables.observations import observations
from labrig.report.tables.paper import compared_conditions, table_3, table_4, table_5, table_6
from labrig.session.format.devices import CalibrationRecord, RecordedDevice
from model import Condition, Measurements, Parameter, Reading, predict
from protocols.execution.events import Outcome
from protocols.planning.schedule import Purpose
from tests.labrig.report_data import POSITIONS_M, STIFFNESS, invalid, measure, truth


@pytest.fixture(scope="module")
def measured():
    return measure()


@pytest.fixture(scope="module")
def fit(measured):
    return fit_what_can_be(measured).fit


def cell(table, row, column):
    line = next(line for line in table.rows if line[0] == row)
    return line[table.columns.index(column)]


def value(text):
    return float(text.split(" ")[0])


@pytest.mark.thorough
@pytest.mark.slow
def test_table_3_tells_this_session_from_the_paper(measured, fit):
    table = table_3(measured, ["long", "short"], fit)
    assert cell(table, "free length l, mm", "short, this session") == "4.5"
    assert cell(table, "rigid elongation, mm", "short, this session") == "40"
    assert cell(table, "held in the clamp, mm", "long, paper") == "1.5"
    assert {table.columns[i] for i in table.quoted} == {"long, paper", "short, paper"}
    assert "24.0 to 6.9" in cell(table, "initial curvature k0, 1/m", "long, this session")


@pytest.mark.slow
def test_table_4_has_the_true_parameters_within_their_intervals(fit):
    table = table_4(fit)
    for name, B in STIFFNESS.items():
        text = cell(table, "bending stiffness B, µN·m²", name)
        sigma = float(text.split("± ")[1])
        assert abs(value(text) - 1e6 * B) < 4 * sigma
        low, high = map(
            float, cell(table, "bending stiffness B, µN·m²", f"{name}, 90 %").split(" to ")
        )
        assert low < value(text) < high
    E_MPa = 12 * STIFFNESS["long"] / (0.011 * 0.00021**3) / 1e6
    young = cell(table, "equivalent Young modulus E, MPa", "long")
    assert value(young) == pytest.approx(E_MPa, rel=0.03)
    assert value(cell(table, "constant EIBM at -2 V, µN·m", "long")) < 0


@pytest.mark.slow
def test_table_5_and_6_have_errors_like_the_papers_for_a_sheet_like_the_papers(measured, fit):
    compared = compared_conditions(measured, fit)
    assert [(c.configuration, c.position_m, c.voltage_V) for c in compared] == [
        ("long", 0.0, 2.0),
        ("short", 0.0, 2.0),
    ]
    five, six = table_5(fit, compared), table_6(fit)
    assert cell(five, "constant EIBM", "long, paper") == "2.23"
    assert 1.5 < value(cell(five, "constant EIBM", "long, this session")) < 3.0
    assert value(cell(five, "EIBM along the sheet", "long, this session")) < 0.1
    assert cell(six, "EIBM along the sheet: force, mN", "short, paper") == "0.424"
    assert 0.3 < value(cell(six, "constant EIBM: force, mN", "long, this session")) < 0.7
    assert value(cell(six, "EIBM along the sheet: force, mN", "long, this session")) < 0.05


@pytest.mark.thorough
@pytest.mark.slow
def test_a_sheet_that_the_paper_does_not_have_gets_no_columns_of_the_paper(measured):
    long = measured.sheets["long"]
    other = replace(
        measured,
        sheets={"wide": replace(long, configuration="wide")},
        conditions=tuple(
            replace(c, configuration="wide")
            for c in measured.conditions
            if c.configuration == "long"
        ),
    )
    fit = fit_what_can_be(other).fit
    assert table_6(fit).columns == ("", "wide, this session")
    assert not table_6(fit).quoted


@pytest.mark.slow
def test_a_configuration_without_valid_readings_is_left_out_and_named(measured):
    fitted = fit_what_can_be(invalid(measured, "short", "the sheet stuck"))
    assert list(fitted.fit.configurations) == ["long"]
    assert "the sheet stuck" in fitted.missing["short"]


def test_a_session_without_any_valid_reading_has_no_fit_but_reasons(measured):
    nothing = invalid(invalid(measured, "short", "it stuck"), "long", "it dried")
    fitted = fit_what_can_be(nothing)
    assert fitted.fit is None
    assert set(fitted.missing) == {"long", "short"}


@pytest.mark.slow
def test_a_fit_without_curves_says_what_it_rests_on_and_when_it_is_wrong():
    fit = fit_what_can_be(measure("long", curves=False)).fit
    (said,) = (text for text in trust(fit) if "no neutral curves" in text)
    assert "where it is not, B and the EIBM are off by more than their intervals" in said


@pytest.mark.slow
def test_of_dozens_of_voltages_the_best_and_the_worst_known_are_told():
    fit = fit_what_can_be(measure("long", curves=False)).fit
    one = fit.configurations["long"]
    many = {v / 10: Parameter(value=1e-6 * v, sigma=1e-8, unit="N m") for v in range(1, 41)}
    said = trust(replace(fit, configurations={"long": replace(one, eibm=many)}))[0]
    assert said.count("constant EIBM") == 2
    assert "(constant EIBM at +4 V) to ±" in said
    assert said.endswith("(constant EIBM at +0.1 V).")


def test_the_forces_where_the_sheets_rest_are_compared():
    made = measure("long", "short")
    rows = {row[0]: row[1:] for row in observations(made, None).rows}
    long = rows["force at the rest position, long sheet, +2 V, -2 V, mN"][0]
    short = rows["force at the rest position, short sheet, +2 V, -2 V, mN"][0]
    model = truth("long", "short")
    for name, cells, rest_m in (("long", long, 0.0144), ("short", short, 0.0047)):
        for cell, volts in zip(cells.split(", "), (2.0, -2.0), strict=True):
            assert float(cell) == pytest.approx(
                1e3 * model.predict(name, rest_m, volts).F_N, abs=0.05
            )
    ratio, theirs = rows["largest force at the rest position, short sheet over long one"]
    assert float(ratio) == pytest.approx(float(short[:4]) / float(long[:4]), abs=0.02)
    assert theirs == "above 1"


def test_observations_have_the_rest_positions_and_the_straight_line_of_the_short_sheet(
    measured, fit
):
    table = observations(measured, fit)
    assert value(cell(table, "rest position of the undriven long sheet, mm", "this session")) == (
        pytest.approx(14.3, abs=0.6)
    )
    share = cell(table, "straightness of F(p), short sheet, +2 V, 0 V, -2 V", "this session")
    assert all(float(text.rstrip(" %")) < 1.0 for text in share.split(", "))


def test_a_rest_position_outside_of_the_positions_is_not_made_up(measured):
    far = tuple(c for c in measured.conditions if c.position_m != 0.0 and c.position_m != 0.01)
    assert rest_position_m(replace(measured, conditions=far), "long") is None


def test_a_line_needs_three_positions(measured):
    two = tuple(c for c in measured.conditions if c.position_m < 0.015)
    assert force_line(replace(measured, conditions=two), "short", 0.0) is None


def test_the_mean_force_leaves_out_what_does_not_count():
    readings = [Reading(index=i, kind="kept", force_N=1e-3) for i in range(3)]
    readings += [
        Reading(index=3, kind="kept", force_N=9.0, valid=False),
        Reading(index=4, kind="discarded", force_N=9.0),
    ]
    force = mean_force(
        Condition(configuration="long", position_m=0.0, voltage_V=2.0, readings=tuple(readings))
    )
    assert (force.mean_N, force.readings) == (pytest.approx(1e-3), 3)


def test_scatter_is_taken_about_the_drift():
    force = 1e-3 + 1e-5 * np.arange(10)
    readings = tuple(
        Reading(index=2 * i, kind="kept", force_N=float(F)) for i, F in enumerate(force)
    )
    scatter_N, drift_N = scatter_and_drift(
        Condition(configuration="long", position_m=0.0, voltage_V=2.0, readings=readings)
    )
    assert scatter_N < 1e-12
    assert drift_N == pytest.approx(9e-5)


def test_every_condition_stands_against_both_simulations(measured, fit):
    assert len(residual_table(fit).rows) == len(measured.conditions)


def test_the_analysis_tables_name_failed_curves_and_invalid_readings(measured):
    broken = invalid(measured, "short", "it stuck")
    first = replace(broken.conditions[0], curve=None)
    broken = replace(broken, conditions=(first, *broken.conditions[1:]))
    rows, summary, reasons = measurements_tables(broken)
    assert reasons.rows[0][1] == "it stuck"
    assert cell(rows, "long, 0 mm, 0 V", "curve") == "none"
    assert cell(rows, "short, 0 mm, +2 V", "invalid") == "10"
    assert cell(summary, "short", "with force") == "0"
    assert cell(summary, "long", "with curve") == "11"
    found = measurements_as_dict(broken)
    one = next(c for c in found["conditions"] if c["configuration"] == "short")
    assert one["force_mN"] is None
    assert one["invalid"][0]["why"] == "it stuck"


def test_reasons_of_invalid_readings_that_differ_in_numbers_alone_are_counted_together():
    whys = ["", "3 samples lost", "12 samples lost", "it stuck"]
    readings = tuple(
        Reading(index=i, kind="kept", force_N=1e-3, valid=not why, why=why)
        for i, why in enumerate(whys)
    )
    condition = Condition(configuration="long", position_m=0.0, voltage_V=2.0, readings=readings)
    *_, reasons = measurements_tables(Measurements(sheets={}, conditions=(condition,)))
    assert reasons.rows == (("2 of 4", "3 to 12 samples lost"), ("1 of 4", "it stuck"))


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        (with_sigma(1.27549, 0.0068), "1.2755 ± 0.0068"),
        (with_sigma(150.25, 12.3), "150 ± 12"),
        (with_sigma(2.0, 0.0), "2"),
        (with_sigma(float("nan"), 0.1), "-"),
        (interval(1.2636165, 1.2873643), "1.2636 to 1.2874"),
        (interval(float("nan"), 1.0), "-"),
        (number(110.4, 2), "110"),
        (number(0.00012345), "0.000123"),
        (fixed(None, 2), "-"),
    ],
)
def test_numbers_have_the_digits_that_their_uncertainty_allows(text, wanted):
    assert text == wanted


@pytest.mark.thorough
@pytest.mark.slow
def test_a_simulated_force_curve_has_the_single_predictions_and_gaps_where_none_is_reachable():
    model = truth("long")
    places = np.array([0.0, 0.012, 0.03, 0.06])
    force = force_curve_N(model, "long", places, -2.0)
    single = [predict(model, "long", float(p), -2.0) for p in places]
    assert force[:3] == pytest.approx([one.F_N for one in single[:3]], rel=1e-9)
    assert not single[3].reachable
    assert np.isnan(force[3])


@pytest.mark.slow
def test_what_shapes_alone_leave_open_is_taken_and_their_ratio_is_told():
    whole = measure()
    bare = tuple(replace(c, readings=()) for c in whole.conditions if c.configuration == "long")
    found = fit_what_can_be(
        replace(whole, sheets={"long": whole.sheets["long"]}, conditions=bare, series=())
    ).fit
    table = table_4(found)
    assert cell(table, "bending stiffness B, µN·m²", "long").endswith(" (taken)")
    assert cell(table, "bending stiffness B, µN·m²", "long, 90 %") == "-"
    ratio = value(cell(table, "constant EIBM/B at +2 V, 1/m", "long"))
    assert ratio == pytest.approx(found.configurations["long"].eibm_over_B[2.0].value, rel=1e-2)
    assert not any("(B)" in said for said in trust(found))
    closed = SimpleNamespace(outcome=Outcome.COMPLETED, runs=())
    fitted = FittedSheets(found)
    shown = cards(Findings(session=closed, measurements=whole, fitted=fitted, why_not=""))
    lines = {label: text for card in shown for label, text, _ in card.lines}
    assert lines["long: B, µN·m²"].endswith(" (taken)")
    assert lines["long: E, MPa"].endswith(" (taken)")
    assert "long, +2 V, B taken" in lines


def test_only_runs_that_should_have_a_curve_are_missed_for_it_and_each_place_is_said_once():
    measured = measure("long")
    touched = replace(measured.conditions[0], curve=None, run=0)
    away = replace(
        touched,
        position_m=None,
        voltage_V=0.0,
        readings=tuple(replace(one, kind="no_contact") for one in touched.readings),
    )
    conditions = (touched, away, replace(away, run=1), replace(away, run=2))
    purposes = [
        (touched.position_m, Purpose.MEASUREMENT),
        (0.002, Purpose.NO_TOUCH_ZERO),
        (None, Purpose.FREE_SHAPE),
        (None, Purpose.FREE_SHAPE),
    ]
    plans = [
        SimpleNamespace(
            index=i, configuration="long", position_m=at, mounting=touched.mounting, purpose=purpose
        )
        for i, (at, purpose) in enumerate(purposes)
    ]
    session = SimpleNamespace(
        frame_shape=(1, 1), runs=[SimpleNamespace(planned=one, started=False) for one in plans]
    )
    found = quality(session, replace(measured, conditions=conditions))
    (said,) = (one for one in found.remarks if "no curve" in one)
    assert said.startswith("3 of 3 conditions have no curve: ")
    assert "long, free, 0 V (2 times)." in said


def test_a_place_that_was_measured_again_is_called_so():
    measured = measure("long")
    again = replace(measured.conditions[0], run=1)
    table = measurements_tables(replace(measured, conditions=(again,)))[0]
    assert "(again 1)" in table.rows[0][0]


def test_measurements_name_the_sheets_that_were_measured():
    measured = measure("long", "short")
    long_alone = [one for one in measured.conditions if one.configuration == "long"]
    some = replace(measured, conditions=tuple(long_alone), series=())
    assert f"{len(long_alone)} conditions of long," in repr(some).splitlines()[0]


def test_values_of_labrig_init_are_no_calibration_of_that_day():
    dates = ("1970-01-01", "2026-03-04", "")
    records = (CalibrationRecord(name="cell.toml", date=date) for date in dates)
    devices = (RecordedDevice(part="load_cell", calibration=record) for record in records)
    table = devices_as_table(tuple(device_row(device) for device in devices))
    assert [row[-1] for row in table.rows] == [
        "never (cell.toml)",
        "2026-03-04 (cell.toml)",
        "not known (cell.toml)",
    ]


@pytest.mark.slow
def test_one_set_up_is_not_said_to_show_the_scatter_between_set_ups():
    one, four = (
        fit_what_can_be(measure("short", positions_m=some)).fit for some in ((0.01,), POSITIONS_M)
    )
    assert "One set-up does not show how set-ups differ" in scatter_table(one).note
    assert "Estimated from the residuals" in scatter_table(four).note


@pytest.mark.slow
def test_notes_keep_names_as_they_are_and_narrow_intervals_are_not_called_zero():
    fit = fit_what_can_be(measure("long", curves=False)).fit
    one = fit.configurations["long"]
    exact = replace(one.B, sigma=1e-4 * one.B.value, freedom=1e4)
    said = trust(
        replace(
            fit,
            notes=("long, 5 mm, 0 V was left out: a bubble", "the EIBM changes"),
            configurations={"long": replace(one, B=exact)},
        )
    )
    assert "±0.02 % (B)" in said[0]
    assert said[-2:] == ["long, 5 mm, 0 V was left out: a bubble.", "The EIBM changes."]


@pytest.mark.slow
def test_the_mean_size_of_eibms_is_that_of_equal_voltages():
    fit = fit_what_can_be(measure("short")).fit
    assert any("mean absolute value" in row[0] for row in table_4(fit).rows)
    one = fit.configurations["short"]
    uneven = replace(one, eibm={1.5: one.eibm[2.0], -2.5: one.eibm[-2.0]})
    table = table_4(replace(fit, configurations={"short": uneven}))
    assert not any("mean absolute value" in row[0] for row in table.rows)
