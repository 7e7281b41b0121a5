"""Arguments that nobody can mean: one sentence, which names the argument."""

from __future__ import annotations

import importlib
import traceback
from dataclasses import replace
from functools import partial
from typing import cast

import numpy as np
import pytest

import labrig
from labrig.api.next_measurement import NextMeasurement
from labrig.cli.main import run
from labrig.errors import BadInputError
from labrig.extractors.choice import chosen_extractor
from model import Prediction, PredictionArray
from model.discrepancy import Next
from tests.labrig.report_data import measure
from tests.labrig.wrong_inputs.files import truth

NUMBERS = {"free_length_mm": 50, "width_mm": 11, "thickness_mm": 0.21}
PAIR = "a number, or a pair (s in mm, k0 in 1/m) of equally long rows is needed"


def sheet(**changes: object) -> labrig.SheetModel:
    return labrig.sheet(**({**NUMBERS, "B_Nm2": 1.27e-6, "EIBM_Nm": 36e-6} | changes))


def said_by(job) -> str:
    with pytest.raises((labrig.LabrigError, labrig.ModelError)) as told:
        job()
    return str(told.value)


# -- a sheet from plain numbers


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"B_Nm2": None, "E_Pa": "1e8"}, "E_Pa '1e8': a number is needed."),
        ({"B_Nm2": "soft"}, "B_Nm2 'soft': a number is needed."),
        ({"EIBM_Nm": {"2": 36e-6}}, "EIBM_Nm '2': a number is needed."),
        ({"initial_curvature_per_m": ([0], [1], [2])}, PAIR),
        ({"initial_curvature_per_m": (0.0, 1.0)}, PAIR),
        ({"initial_curvature_per_m": ([0, 50], [1])}, PAIR),
        ({"initial_curvature_per_m": ([0, "a"], [1, 1])}, "'a': a number is needed"),
        ({"initial_curvature_per_m": "measured"}, PAIR),
    ],
)
def test_what_is_no_number_of_a_sheet_is_one_sentence(changes, said):
    assert said in said_by(lambda: sheet(**changes))


@pytest.mark.parametrize(
    ("k0", "said"),
    [
        (([0, 0.05], [1, 1]), "initial_curvature_per_m s_mm: 0.001 of the free length"),
        (1e4, "initial_curvature_per_m: 2.865e+04 deg, wanted 0 to 360 deg"),
    ],
)
def test_an_initial_curvature_in_another_unit_is_refused(k0, said):
    assert said in said_by(lambda: sheet(initial_curvature_per_m=k0))


def test_rows_of_an_initial_curvature_are_in_mm_and_per_m():
    bent = sheet(initial_curvature_per_m=[[0, 50], [2.0, 4.0]]).sheets["sheet"].sheet
    assert [list(row) for row in bent.initial_curvature] == [[0.0, 0.05], [2.0, 4.0]]


# -- EIBMs of one's own


def branching(s_m):
    return 1e-6 if s_m > 0.01 else 0.0


def test_a_fault_inside_an_eibm_function_is_told_with_its_place_and_cause():
    with pytest.raises(labrig.ModelError) as told:
        sheet(EIBM_Nm=branching)
    said = str(told.value)
    line = branching.__code__.co_firstlineno + 1
    assert f"failed in test_wrong_arguments.py, line {line}: ValueError: The truth value" in said
    assert isinstance(told.value.__cause__, ValueError)
    assert "branching" in "".join(traceback.format_exception(told.value))


@pytest.mark.parametrize("found", [np.ones(3), "large", None])
def test_an_eibm_function_must_return_a_number_for_each_place(found):
    said = said_by(lambda: sheet(EIBM_Nm={2.0: lambda _s_m: found}))
    assert "returned" in said
    assert "as many as there are places s_m (51)" in said


def test_lists_are_rows_of_an_eibm_and_functions_may_return_one_number():
    rows = sheet(EIBM_Nm={2.0: [[0.0, 0.05], [36e-6, 20e-6]]}).sheets["sheet"]
    same = sheet(EIBM_Nm={2.0: ([0.0, 0.05], [36e-6, 20e-6])}).sheets["sheet"]
    assert rows.mean_eibm(2.0) == same.mean_eibm(2.0)
    constant = sheet(EIBM_Nm={2.0: lambda _s_m: 36e-6}).sheets["sheet"]
    assert constant.mean_eibm(2.0) == pytest.approx(36e-6)


@pytest.mark.parametrize("wrong", ["36e-6", [36e-6], ([0.0, 0.05], "ab"), None])
def test_what_is_no_eibm_is_one_sentence(wrong):
    said = said_by(lambda: labrig.simulate(sheet(), position_mm=5, eibm={2.0: wrong}))
    assert "must be a number in N m, a function of s_m, or a pair" in said


# -- predictions


@pytest.mark.parametrize("volts", [2, 2.0, np.int64(2), np.float32(2), np.float64(2), np.array(2)])
def test_two_numbers_give_a_prediction_whatever_their_type(volts):
    one = labrig.predict(sheet(), "sheet", np.float32(0.01), volts)
    assert isinstance(one, Prediction)
    assert isinstance(one.voltage_V, float)
    assert isinstance(labrig.predict(sheet(), "sheet", [0.01], volts), PredictionArray)


@pytest.mark.parametrize("wrong", ["x", "5", None, [0.0, [1.0]], ["5"]])
def test_a_place_that_is_no_number_is_one_sentence_of_predict(wrong):
    for place in ((wrong, 2), (0.01, wrong)):
        said = said_by(lambda place=place: labrig.predict(sheet(), "sheet", *place))
        assert "a number or an array of numbers is needed" in said or "finite numbers" in said


@pytest.mark.parametrize("wrong", [np.ma.masked_array([0.01, 0.02], [False, True]), [0.01 + 0j]])
def test_what_a_mask_hides_and_half_of_a_complex_number_are_not_predicted(wrong):
    said = said_by(lambda: labrig.predict(sheet(), "sheet", wrong, 2.0))
    assert "position_m" in said
    assert "a number or an array of numbers is needed" in said
    assert "\n" not in said


@pytest.mark.parametrize("volts", [np.float32(1.1), -1.1 - 1e-8, [np.float32(1.1)]])
def test_a_voltage_of_32_bits_is_the_one_that_was_fitted(volts):
    model = sheet(EIBM_Nm={1.1: 36e-6, -1.1: -28e-6})
    asked = labrig.predict(model, "sheet", 0.01, volts)
    exact = labrig.predict(model, "sheet", 0.01, np.sign(volts) * 1.1)
    np.testing.assert_allclose(asked.F_N, exact.F_N)
    assert "1.11 V is outside" in said_by(lambda: labrig.predict(model, "sheet", 0.01, 1.11))


def test_a_list_is_no_name_of_a_sheet():
    said = said_by(lambda: labrig.predict(sheet(), ["sheet"], 0.01, 2.0))
    assert said.startswith("the model has no configuration '['sheet']'")


def test_arrays_and_pairs_of_arrays_have_a_type_of_an_argument():
    """What is written here is what mypy accepts."""
    rows = (np.array([0.0, 0.05]), np.array([36e-6, 12e-6]))
    model = labrig.sheet(**NUMBERS, B_Nm2=1.27e-6, EIBM_Nm={2.0: rows})
    found = labrig.simulate(model, position_mm=np.array([0.0, 10.0]), voltage=2)
    one: Prediction = labrig.predict(model, "sheet", 0.01, 2.0)
    both: PredictionArray = labrig.predict(model, "sheet", np.array([0.0, 0.01]), 2.0)
    assert [each.F_N for each in found][1] == one.F_N == pytest.approx(both.F_N[1])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"session": -1}, "session -1: a number from 0 is needed."),
        ({"session": "1"}, "session '1': a number is needed."),
        ({"session": 0.5}, "session 0.5: a whole number is needed."),
        ({"session": 1}, "session 1: the model has nothing that differs between sessions."),
        ({"position_mm": float("nan")}, "position_mm nan: a number is needed."),
    ],
)
def test_a_wrong_argument_of_simulate_is_one_sentence(options, said):
    asked = {"position_mm": 5, "voltage": 2} | options
    assert said_by(lambda: labrig.simulate(sheet(), **asked)) == said


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"every_ms": "x"}, "every_ms 'x': a number is needed."),
        ({"every_ms": 0}, "every_ms 0: a number above 0 is needed."),
        ({"start_ms": None}, "start_ms None: a number is needed."),
        ({"position_mm": "5"}, "position_mm '5': a number is needed."),
        ({"run": 1.5}, "run 1.5: a whole number is needed."),
    ],
)
def test_a_wrong_argument_of_simulate_in_time_is_one_sentence(options, said):
    assert said_by(lambda: labrig.simulate_in_time("m.toml", "p.toml", **options)) == said


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"mass_g": None}, "mass_g None: a number is needed."),
        ({"lag_s": float("inf")}, "lag_s inf: a number is needed."),
    ],
)
def test_a_wrong_argument_of_design_is_one_sentence(options, said):
    assert said_by(lambda: labrig.design(sheet(), (0, 20), **options)) == said


# -- what is fitted


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"bootstrap": float("nan")}, "bootstrap nan: a number is needed."),
        ({"bootstrap": 20.5}, "bootstrap 20.5: a whole number is needed."),
        ({"bootstrap": -20}, "bootstrap -20: a number from 0 is needed."),
        ({"stiffness_Nm2": -1}, "stiffness_Nm2 -1: a number above 0 is needed."),
    ],
)
def test_a_wrong_argument_of_fit_is_one_sentence(options, said):
    assert said_by(lambda: labrig.fit("session.h5", **options)) == said


@pytest.mark.parametrize("given", ["5", -1, 0, float("nan")])
@pytest.mark.parametrize("function", ["compare", "fit_in_time", "next_in_time"])
def test_the_mass_of_an_elongation_has_one_rule_and_is_checked_first(function, given):
    ask = getattr(labrig, function)
    said = said_by(lambda: ask("gone.h5", elongation_g_per_m=given))
    wanted = "a number above 0" if given in (-1, 0) else "a number"
    assert said == f"elongation_g_per_m {given!r}: {wanted} is needed."


@pytest.mark.parametrize("between", [3, ("gravity", 3), {"gravity": 1}])
def test_what_names_no_two_effects_is_one_sentence(between):
    said = said_by(lambda: labrig.next_measurement(measure("long"), between=between))
    assert said == f"between {between!r}: name two effects, such as gravity and clamp_angle."


def test_the_command_line_names_its_options(capsys):
    for asked, said in (
        (("compare", "gone.h5", "--elongation-g-per-m", "-1"), "--elongation-g-per-m -1: a number"),
        (("design", "gone.toml", "--section", "9"), "--section '9': two positions"),
        (("fit", "gone.h5", "--bootstrap", "5"), "--bootstrap 5: give at least 20, or 0."),
    ):
        assert run(list(asked)) == 2
        assert said in capsys.readouterr().err


def test_a_path_that_has_an_arguments_name_stays_as_it_is():
    error = labrig.errors.BadArgumentError("model/model.toml: give model.", "model")
    assert error.in_words(lambda _name: "--model") == "model/model.toml: give --model."
    assert isinstance(error, BadInputError)


def test_an_export_names_its_format_and_the_command_its_option(tmp_path, capsys):
    said = said_by(lambda: labrig.export(tmp_path / "gone.h5", tmp_path, format="dvd"))
    assert said.startswith("format: ")
    assert run(["export", "gone.h5", "-o", str(tmp_path / "x"), "--as", "dvd"]) == 2
    assert capsys.readouterr().err == f"labrig: --as: {said.removeprefix('format: ')}\n"


# -- all options at once


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"symmetric": True, "q": 2.0}, "symmetric, q"),
        ({"hold_out": "position=20"}, "hold_out"),
        ({"configuration": "long", "bootstrap": 20}, "configuration, bootstrap"),
        ({"stiffness_Nm2": 1e-6, "measured_curvature": True}, "measured_curvature, stiffness_Nm2"),
    ],
)
def test_fit_refuses_arguments_beside_options(given, named):
    said = said_by(lambda: labrig.fit("gone.h5", labrig.FitOptions(), **given))
    assert said == f"options hold {named}: give each once, there or as an argument."


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"symmetric": True, "calibrate": 20}, "symmetric, calibrate"),
        ({"hold_out": "position=20", "without": "gravity"}, "hold_out, without"),
        ({"model": "m.toml", "stiffness_Nm2": 1e-6}, "model, stiffness_Nm2"),
    ],
)
def test_diagnose_refuses_arguments_beside_options(given, named):
    said = said_by(lambda: labrig.diagnose("gone.h5", labrig.DiagnoseOptions(), **given))
    assert said == f"options hold {named}: give each once, there or as an argument."


def test_options_of_a_diagnosis_are_checked_and_completed_as_arguments_are(monkeypatch):
    module = importlib.import_module("labrig.api.diagnose")
    kept = object()
    monkeypatch.setattr(module, "promises_kept_in", lambda _sessions: (kept,))
    asked = []
    monkeypatch.setattr(module, "diagnosed_and_kept", lambda *given: asked.append(given[2]))
    measured = measure("long")
    with pytest.warns(labrig.LabrigWarning, match="stiffness_Nm2 is not used"):
        labrig.diagnose(measured, labrig.DiagnoseOptions(stiffness_Nm2=1e-6))
    with pytest.warns(labrig.LabrigWarning, match="stiffness_Nm2 is not used"):
        labrig.diagnose(measured, stiffness_Nm2=1e-6)
    assert [one.promised for one in asked] == [(kept,), (kept,)]
    assert asked[0] == asked[1]
    with pytest.raises(labrig.ModelError, match="`labrig effects` lists them"):
        labrig.diagnose("gone.h5", labrig.DiagnoseOptions(exclude=("foo",)))


def test_a_protocol_that_is_there_already_names_the_argument(tmp_path):
    found = NextMeasurement(proposal=cast("Next", None), protocol="")
    (tmp_path / "next.toml").touch()
    said = said_by(lambda: found.save(tmp_path / "next.toml"))
    assert said.endswith("next.toml: is already there; give force to overwrite it.")


def test_a_model_file_is_replaced_only_where_the_caller_says_so(tmp_path):
    path = tmp_path / "keep.toml"
    path.write_text("precious")
    said = said_by(lambda: labrig.save_model(truth(), path))
    assert said.endswith("keep.toml: is already there; give force to overwrite it.")
    assert path.read_text() == "precious"
    labrig.save_model(truth(), path, force=True)
    assert labrig.load_model(path).sheets


# -- what is of another kind


@pytest.mark.parametrize(
    "function",
    ["open_session", "load_model", "load_optics", "read_image", "load_measurements", "analyze"],
)
@pytest.mark.parametrize(("given", "said"), [(None, "None"), (3, "an int"), (b"x", "a bytes")])
def test_what_is_no_file_is_told(function, given, said):
    assert said_by(lambda: getattr(labrig, function)(given)) == f"a file is needed, not {said}."


def test_what_is_no_model_is_told_before_a_file_is_written(tmp_path):
    fitted = labrig.fit(measure("long"))
    said = said_by(lambda: labrig.save_model(fitted, tmp_path / "m.toml"))
    three = "preferred_model, model and varying_model"
    assert said == f"a model is needed, not a Fit; a fit has three: {three}."
    assert said_by(lambda: labrig.save_model(None, "m.toml")) == "a model is needed, not None."
    assert not list(tmp_path.iterdir())


def test_figures_are_drawn_into_one_axes_of_what_was_diagnosed():
    from matplotlib.figure import Figure

    both, eibm = Figure().subplots(2), labrig.plot.eibm
    wanted = "ax: one matplotlib Axes is needed, not a"
    assert said_by(lambda: eibm(sheet(), ax=both)) == f"{wanted} ndarray."
    assert said_by(lambda: eibm(sheet(), ax=both[0].figure)) == f"{wanted} Figure."
    for draw in (labrig.plot.diagnosis, labrig.plot.diagnosis_forces):
        assert "what labrig.diagnose returns is needed, not a str" in said_by(partial(draw, "s.h5"))


def test_what_is_no_prediction_is_not_drawn():
    wanted = "predictions are needed, as labrig.predict and labrig.simulate return them, not "
    assert said_by(lambda: labrig.plot.shapes(sheet(), sheet())) == f"{wanted}a SheetModel."
    assert said_by(lambda: labrig.plot.shapes(["long"], sheet())) == f"{wanted}a str."


@pytest.mark.parametrize("given", ["sheet.toml", None])
def test_tables_are_read_for_sheets_and_not_for_the_name_of_their_file(given):
    said = said_by(lambda: labrig.read_tables(given, "forces.csv"))
    assert "sheets by their names are needed, not" in said
    assert "labrig.measurements_of_tables takes sheet.toml" in said


def test_a_curve_is_looked_for_with_optics_and_a_strip():
    strip = labrig.StripGeometry(free_length_m=0.03)
    optics = labrig.Optics(px_per_mm=4, clamp_px=(24, 75))
    pixels = np.zeros((150, 200), np.uint8)
    assert said_by(lambda: labrig.neutral_curve(pixels, "optics.json", strip)) == (
        "optics: a labrig.Optics is needed, not a str; labrig.load_optics reads a file."
    )
    assert said_by(lambda: labrig.neutral_curve(pixels, optics, "sheet.toml")) == (
        "strip: a labrig.StripGeometry is needed, not a str."
    )
    assert said_by(lambda: labrig.neutral_curve(pixels, optics, strip, start="last")) == (
        "start: a labrig.NeutralCurve is needed, not a str."
    )
    assert said_by(lambda: labrig.StripGeometry(free_length_m="0.03")) == (
        "free_length_m '0.03': a number is needed."
    )


@pytest.mark.parametrize(
    ("extractor", "said"),
    [
        ("gone", "extractor: there is no curve extractor 'gone'; choose one of: intensity_fit."),
        (None, "extractor: a text is needed, not None."),
    ],
)
def test_an_extractor_is_named_as_the_function_names_it(extractor, said):
    assert said_by(lambda: chosen_extractor(extractor)) == said


# -- arguments that a function does not have


@pytest.mark.parametrize(
    ("job", "said"),
    [
        (
            lambda: labrig.predict("model.toml", "long", position_mm=12, voltage_V=2),
            (
                "predict() has no argument 'position_mm'; did you mean position_m? Its "
                "arguments are model, configuration, position_m, voltage_V."
            ),
        ),
        (
            lambda: labrig.simulate("model.toml", position_mm=12, voltage_V=2),
            (
                "simulate() has no argument 'voltage_V'; did you mean voltage? Its arguments are "
                "model, position_mm, voltage, configuration, session, eibm."
            ),
        ),
        (
            lambda: labrig.fit("session.h5", model="constant"),
            (
                "fit() has no argument 'model'; its arguments are sessions, options, "
                "configuration, hold_out, apart, symmetric, measured_curvature, bootstrap, q, "
                "stiffness_Nm2, progress."
            ),
        ),
        (
            lambda: labrig.simulate("model.toml", "long", 12, 2),
            (
                "simulate() takes 1 argument without a name, not 4; give by name: position_mm=, "
                "voltage=, configuration=, session=, eibm=."
            ),
        ),
        (
            lambda: labrig.plot.forces("session.h5", configurations="long"),
            (
                "forces() has no argument 'configurations'; did you mean configuration? Its "
                "arguments are data, model, configuration, ax."
            ),
        ),
        (
            lambda: labrig.open_session("session.h5", lives=True),
            (
                "open_session() has no argument 'lives'; did you mean live? Its arguments are "
                "path, live."
            ),
        ),
        (
            lambda: labrig.Note("me", "a note"),
            (
                "Note() takes 0 arguments without a name, not 2; give by name: who=, text=, "
                "when=, media_type=, file_name=, photograph=, identifier=."
            ),
        ),
    ],
)
def test_an_argument_that_a_function_does_not_have_is_one_sentence(job, said):
    with pytest.raises(TypeError) as told:
        job()
    assert str(told.value) == said


@pytest.mark.parametrize("kind", [labrig.FitOptions, labrig.DiagnoseOptions])
def test_an_option_that_there_is_not_is_answered_with_its_right_name(kind):
    said = rf"^{kind.__name__}\(\) has no argument 'simmetric'; did you mean symmetric"
    with pytest.raises(TypeError, match=said):
        kind(simmetric=True)
    with pytest.raises(TypeError, match="no argument 'simmetric'; did you mean symmetric"):
        replace(kind(), simmetric=True)
    assert repr(kind(symmetric=True)) == repr(replace(kind(), symmetric=True))


@pytest.mark.parametrize(
    ("job", "kind"),
    [(labrig.fit, "labrig.FitOptions"), (labrig.diagnose, "labrig.DiagnoseOptions")],
)
def test_what_is_no_options_is_refused_with_what_is_needed(job, kind):
    said = said_by(lambda: job(measure("short"), "short"))
    assert said == (
        f"options: a {kind} is needed, not a str; all other arguments are given by name."
    )
    assert f"a {kind} is needed, not a dict" in said_by(lambda: job(measure("short"), {}))
