"""What a console and a notebook show of labrig's objects, and their data frames."""

from __future__ import annotations

import copy
import sys
from dataclasses import replace

import numpy as np
import pytest

import labrig
from labrig.errors import BadInputError
from model import Measurements, ModelError
from model.measurements import Displayed, MissingPandasError, Summary
from model.measurements.display import MOST_LETTERS, MOST_NOTES, MOST_ROWS
from model.sheet.prediction import predict
from tests.labrig.report_data import POSITIONS_M, measure, session, truth

SCREEN = 24  # lines of a terminal


@pytest.fixture(scope="module")
def measured() -> Measurements:
    return measure("long", "short")


@pytest.fixture(scope="module")
def session_file(tmp_path_factory, measured):
    return session(tmp_path_factory.mktemp("display") / "session.h5", measured)


def assert_one_screen(shown: Displayed) -> None:
    text = repr(shown)
    assert text == str(shown)
    assert 1 <= len(text.splitlines()) <= SCREEN
    assert max(map(len, text.splitlines())) <= MOST_LETTERS
    assert len(shown._repr_html_()) < 20_000


@pytest.mark.slow
def test_large_measurements_fit_one_screen(measured):
    many = replace(measured, conditions=measured.conditions * 50, warnings=("a",) * 30)
    assert_one_screen(many)
    assert f"... {len(many.conditions) - MOST_ROWS + 1} more rows" in repr(many)
    assert f"... {30 - MOST_NOTES} more notes" in repr(many)


def test_each_part_of_measurements_fits_one_screen(measured):
    one = measured.conditions[0]
    for part in (one, one.readings[0], one.curve, measured.series[0], measured.sheets["long"]):
        assert_one_screen(part)
    assert "long, 0 mm, 0 V" in repr(one)
    assert "50 x 11 x 0.21 mm" in repr(measured.sheets["long"])


@pytest.mark.thorough
@pytest.mark.slow
def test_models_and_predictions_fit_one_screen():
    model = truth("long", "short")
    for shown in (model, model.sheets["long"], model.sheets["long"].eibm[2.0]):
        assert_one_screen(shown)
    assert_one_screen(predict(model, "long", 0.01, 2.0))
    far = predict(model, "long", 0.1, 2.0)
    assert_one_screen(far)
    assert "not reachable" in repr(far)


@pytest.mark.slow
def test_a_session_shows_its_runs_and_that_it_is_closed(session_file):
    with labrig.open_session(session_file) as opened:
        assert_one_screen(opened)
        assert "completed" in repr(opened)
        assert "8 of 8" in repr(opened)
        run = opened.run(0)
        assert_one_screen(run)
    assert repr(opened).endswith("closed")
    assert "closed" in repr(run)


def test_a_curve_of_an_image_says_why_it_is_none():
    lost = labrig.NeutralCurve(ok=False, why="nothing bends in it")
    assert repr(lost) == "NeutralCurve: no curve: nothing bends in it"


def test_html_is_escaped():
    summary = Summary("<a>", ("x", "y"), [("<b>", "1 & 2")], ("<i>",))
    html = summary.html()
    assert "<b>" not in html
    assert "&lt;a&gt;" in html
    assert "1 &amp; 2" in html


# -- data frames


@pytest.mark.slow
def test_readings_become_rows_in_si_units(measured):
    frame = measured.to_dataframe("readings")
    assert len(frame) == sum(len(c.readings) for c in measured.conditions)
    assert list(frame.columns[:3]) == ["configuration", "position_m", "voltage_V"]
    one = measured.conditions[4]
    same = frame[
        (frame.configuration == one.configuration)
        & (frame.position_m == one.position_m)
        & (frame.voltage_V == one.voltage_V)
    ]
    assert same.force_N.tolist() == [r.force_N for r in one.readings]


@pytest.mark.slow
def test_conditions_hold_the_mean_of_the_readings_in_use(measured):
    frame = measured.to_dataframe()
    assert len(frame) == len(measured.conditions)
    force_N = [np.mean([r.force_N for r in c.used()]) for c in measured.conditions]
    assert frame.force_N.to_numpy() == pytest.approx(force_N)
    assert set(frame.position_m) == set(POSITIONS_M)


@pytest.mark.slow
def test_a_place_that_was_measured_again_says_so_and_is_no_number_of_a_run(measured):
    twice = replace(
        measured, conditions=(measured.conditions[0], replace(measured.conditions[0], run=1))
    )
    frame = twice.to_dataframe()
    assert frame.again.tolist() == [0, 1]
    for part in ("conditions", "readings", "curves", "signals"):
        assert "again" in measured.to_dataframe(part).columns
        assert "run" not in measured.to_dataframe(part).columns


@pytest.mark.slow
def test_curves_and_signals_become_rows(measured):
    curves = measured.to_dataframe("curves")
    assert len(curves) == sum(len(c.curve.s_m) for c in measured.conditions)
    signals = measured.to_dataframe("signals")
    assert len(signals) == sum(len(s.time_s) for s in measured.series)
    assert {"time_s", "drive_V", "current_A"} <= set(signals.columns)
    assert len(measured.series[0].to_dataframe()) == len(measured.series[0].time_s)
    curve = measured.conditions[0].curve
    assert curve.to_dataframe().x_m.to_numpy() == pytest.approx(curve.x_m)


@pytest.mark.slow
def test_an_unknown_part_is_one_sentence(measured, session_file):
    with pytest.raises(ModelError, match="no part 'forces', but conditions, readings"):
        measured.to_dataframe("forces")
    with (
        labrig.open_session(session_file) as opened,
        pytest.raises(BadInputError, match="no part 'curves', but readings, runs"),
    ):
        opened.to_dataframe("curves")


@pytest.mark.slow
def test_a_session_gives_its_readings_runs_and_samples(session_file):
    with labrig.open_session(session_file) as opened:
        readings, runs = opened.to_dataframe(), opened.to_dataframe("runs")
        samples = opened.run(0).to_dataframe()
        recorded = opened.run(0).readings
    first = readings[readings.run == 0]
    assert first.force_N.to_numpy() == pytest.approx(recorded["force_N"])
    assert len(runs) == 4
    assert runs.completed.all()
    assert {"time_s", "force_V", "drive_V"} <= set(samples.columns)


def test_a_predicted_shape_becomes_rows():
    found = predict(truth("long"), "long", 0.01, 2.0)
    assert found.to_dataframe().y_m.to_numpy() == pytest.approx(found.y_m)


def test_without_pandas_one_sentence_says_how_to_install_it(measured, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingPandasError, match=r'pip install "labrig\[dataframe\]"'):
        measured.to_dataframe()


# -- names that are guessed


def test_a_name_that_an_object_does_not_have_is_answered_with_those_that_it_has(measured):
    with pytest.raises(AttributeError) as told:
        measured.sheets["long"].length  # noqa: B018 - it raises
    text = str(told.value)
    assert text.startswith("'SheetGeometry' object has no attribute 'length'; it has ")
    assert "free_length_m" in text
    assert "summary()" in text
    assert not hasattr(measured, "_ipython_display_")
    assert copy.deepcopy(measured.conditions[0].readings[0]) is not None


def test_a_property_that_fails_says_why_itself():
    class Broken(Displayed):
        def summary(self) -> Summary:
            return Summary("broken")

        @property
        def force_N(self) -> float:
            raise AttributeError("the cell is not there")

    with pytest.raises(AttributeError, match="the cell is not there"):
        Broken().force_N  # noqa: B018 - it raises
