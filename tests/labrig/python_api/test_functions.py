"""The commands as functions: `import labrig` in a script or a notebook."""

from __future__ import annotations

import doctest
import importlib
import inspect
import json
import re
from importlib import import_module

import numpy as np
import pytest

import labrig
from labrig.cli.main import run
from labrig.errors import BadInputError
from labrig.report.tables.cross_validation import left_out_rows
from labrig.session.tables.drive_table import load_protocol
from labrig.session.tables.examples import write_examples
from model import ModelError, SheetModel
from model.sheet.misfit import CURVE, FORCE, FORCE_SIZE
from tests.labrig.report_data import STIFFNESS, measure, session, truth

pytestmark = pytest.mark.usefixtures("data_unchecked")

FUNCTIONS = (
    "compare", "design", "diagnose", "fit", "fit_in_time", "map_of_elongation",
    "measurements_of_tables", "next_in_time", "next_measurement", "predict", "run", "sheet",
    "simulate", "simulate_in_time",
)  # fmt: skip
MODULES = ("design", "sheet", "simulate")  # the others need a session


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("functions")


@pytest.fixture(scope="module")
def session_file(folder):
    return session(folder / "session.h5", measure("long"))


@pytest.fixture(scope="module")
def fitted(session_file):
    return labrig.fit(str(session_file))


@pytest.fixture(scope="module")
def model_file(folder):
    path = folder / "model.toml"
    labrig.save_model(truth("long", "short"), path)
    return path


def long_sheet(**changes: object) -> SheetModel:
    numbers = {"free_length_mm": 50, "width_mm": 11, "thickness_mm": 0.21, "B_Nm2": 1.27e-6}
    return labrig.sheet(**({**numbers, "EIBM_Nm": 36e-6} | changes))


def printed_json(capsys, *arguments: object):
    assert run([*map(str, arguments), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


# -- help


@pytest.mark.slow
@pytest.mark.parametrize("module", MODULES)
def test_the_examples_of_the_docstrings_run(module):
    found = doctest.testmod(import_module(f"labrig.api.{module}"), report=True)
    assert found.failed == 0
    assert found.attempted > 0


@pytest.mark.parametrize("name", FUNCTIONS)
def test_help_explains_every_argument_and_shows_an_example(name):
    function = getattr(labrig, name)
    text = inspect.getdoc(function)
    for argument in inspect.signature(function).parameters:
        assert f"{argument}:" in text.partition("Args:")[2], argument
    for part in ("Returns:", "Raises:", "Example:", ">>> "):
        assert part in text, part


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_argument_has_a_type(name):
    function = getattr(labrig, name)
    assert all(
        p.annotation is not inspect.Parameter.empty
        for p in inspect.signature(function).parameters.values()
    )


# -- fit


@pytest.mark.slow
def test_fit_takes_text_paths_and_measurements(session_file, fitted):
    B = fitted.configurations["long"].B
    assert abs(B.value - STIFFNESS["long"]) < 4 * B.sigma
    measurements = labrig.load_measurements(str(session_file))
    for given in (session_file, [str(session_file)], measurements):
        assert labrig.fit(given).configurations["long"].B.value == pytest.approx(B.value, rel=1e-9)
    frame = fitted.to_dataframe()
    row = frame[(frame.configuration == "long") & (frame.parameter == "B")].iloc[0]
    assert row["value"] == B.value
    assert row.low90 < B.value < row.high90


@pytest.mark.thorough
@pytest.mark.slow
def test_fit_is_what_the_command_prints(session_file, capsys):
    printed = printed_json(capsys, "fit", session_file, "--hold-out", "position=20")
    found = labrig.fit(session_file, hold_out="position=20")
    B = printed["configurations"]["long"]["B_Nm2"]["value"]
    assert found.configurations["long"].B.value == pytest.approx(B, rel=1e-12)
    assert found.model.held_out


@pytest.mark.slow
def test_wrong_arguments_of_fit_are_one_sentence(session_file):
    with pytest.raises(BadInputError, match="give at least 20, or 0"):
        labrig.fit(session_file, bootstrap=5)
    with pytest.raises(BadInputError, match="nothing was measured of it"):
        labrig.fit(session_file, configuration="wide")
    with pytest.raises(BadInputError, match="several sessions"):
        labrig.fit(session_file, apart=True)


@pytest.mark.parametrize(
    ("held", "said"),
    [
        (("short", 10.0), "('short', 10.0): nothing was measured there; the positions of 'short'"),
        (("wide", 0.01), "('wide', 0.01): nothing was measured there; the positions of 'wide' are"),
        (("short", 0.01, 3.0), "('short', 0.01, 3.0): nothing was measured there"),
    ],
)
def test_what_is_held_out_by_options_must_have_been_measured(held, said):
    options = labrig.FitOptions(held_out=(held,))
    with pytest.raises(BadInputError, match=re.escape(said)):
        labrig.fit(measure("short"), options)


@pytest.mark.slow
@pytest.mark.parametrize("held", [("short", 0.010004, 2.0), ("", 0.01, 2.0)])
def test_what_options_hold_out_is_predicted_also_of_one_voltage_and_a_rounded_position(held):
    data = measure("short")
    found = labrig.fit(data, labrig.FitOptions(held_out=(held,)))
    assert found.model.held_out == ("short, 10 mm, +2 V",)
    (row,) = left_out_rows(found, data)
    assert (row.position_m, row.voltage_V) == (0.01, 2.0)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"bootstrap": "20"}, "bootstrap '20': a number is needed."),
        ({"q": None}, "q None: a number is needed."),
        ({"stiffness_Nm2": "1e-6"}, "stiffness_Nm2 '1e-6': a number is needed."),
        ({"hold_out": 25}, "hold_out '25': write position=25 or configuration=long,position=25."),
    ],
)
def test_a_wrong_type_is_one_sentence_of_fit(session_file, options, said):
    with pytest.raises(BadInputError) as told:
        labrig.fit(session_file, **options)
    assert str(told.value) == said


@pytest.mark.slow
def test_a_wrong_type_is_one_sentence_of_diagnose_and_next(session_file):
    with pytest.raises(BadInputError, match="calibrate '5': a number is needed"):
        labrig.diagnose(session_file, calibrate="5")
    with pytest.raises(BadInputError, match="most_effects 0: a number from 1 is needed"):
        labrig.diagnose(session_file, most_effects=0)
    with pytest.raises(BadInputError, match="hold_out '25': write position=25"):
        labrig.diagnose(session_file, hold_out=25)
    for between in ("gravity", ("gravity",), ("gravity", "clamp_angle", "roll_offset")):
        with pytest.raises(BadInputError, match="name two effects, such as gravity and clamp_ang"):
            labrig.next_measurement(session_file, between=between)
    with pytest.raises(labrig.ModelError, match="36 others: `labrig effects` lists them"):
        labrig.diagnose(session_file, without="foo")


@pytest.mark.slow
def test_a_stiffness_that_the_forces_determine_is_said_not_to_be_used(session_file):
    with pytest.warns(labrig.LabrigWarning, match="not used: forces were measured of long, w"):
        labrig.fit(session_file, configuration="long", stiffness_Nm2=1e-6)


def test_why_several_sheets_are_not_compared_in_time_is_one_sentence(session_file, monkeypatch):
    compare = importlib.import_module("labrig.api.compare")
    monkeypatch.setattr(compare, "_in_time", lambda *_: ([], {"a": "A rests.", "b": "B, too."}))
    with pytest.raises(BadInputError) as told:
        labrig.compare(session_file, dynamic=True)
    assert str(told.value) == "A rests; B, too."


@pytest.mark.slow
def test_a_note_may_be_a_text(tmp_path):
    path = session(tmp_path / "s.h5", measure("long"))
    assert labrig.add_note(str(path), "the sheet looks dry")
    with labrig.open_session(path) as opened:
        assert [note.text for note in opened.notes] == ["the sheet looks dry"]
    for wrong in (5, None):
        with pytest.raises(BadInputError, match=f"a text or a labrig.Note, not {wrong}"):
            labrig.add_note(path, wrong)
    with pytest.raises(BadInputError, match="needs a text"):
        labrig.add_note(path, " ")


# -- tables of other programs


NAMES = {"position_mm": "p", "voltage_V": "U", "force_mN": "F", "sd_mN": "std", "mean_of": "n"}


def test_tables_with_other_names_are_read_as_the_command_reads_them(tmp_path):
    write_examples(tmp_path)
    files = (tmp_path / "sheet.toml", tmp_path / "labview.txt")
    with pytest.warns(labrig.LabrigWarning) as told:
        found = labrig.measurements_of_tables(
            *files, columns=NAMES, values={"configuration": "long"}
        )
    assert "F (N) is force_mN" in " ".join(str(one.message) for one in told)
    assert {one.filename for one in told} == {__file__}  # the caller's line, not one of labrig's
    assert len(found.conditions) == 12
    texts = [f"{ours}={theirs}" for ours, theirs in NAMES.items()]
    with pytest.warns(labrig.LabrigWarning):
        same = labrig.measurements_of_tables(*files, columns=texts, values="configuration=long")
    assert [c.readings[0].force_N for c in same.conditions] == [
        c.readings[0].force_N for c in found.conditions
    ]


def test_wrong_names_of_columns_are_one_sentence(tmp_path):
    write_examples(tmp_path)
    with pytest.raises(BadInputError, match="'strength' is no column of labrig's"):
        labrig.measurements_of_tables(
            tmp_path / "sheet.toml", tmp_path / "labview.txt", columns={"strength": "F"}
        )
    with pytest.raises(BadInputError, match="either a session or CSV tables"):
        labrig.diagnose("session.h5", columns={"force_mN": "F"})


# -- the next measurement


@pytest.mark.thorough
@pytest.mark.slow
def test_the_next_measurement_is_what_the_command_prints(session_file, folder, capsys):
    between = ("gravity", "clamp_angle")
    found = labrig.next_measurement(session_file, between=between)
    printed = printed_json(capsys, "next", session_file, "--between", *between)
    assert found.to_json() == printed
    assert len(repr(found).splitlines()) <= 24
    assert "Separation of the candidates" in " ".join(repr(found).split())
    found.save(folder / "next.toml")
    assert load_protocol(folder / "next.toml")
    with pytest.raises(labrig.LabrigError, match="is already there"):
        found.save(folder / "next.toml")
    with pytest.raises(BadInputError, match="name two different effects"):
        labrig.next_measurement(session_file, between=("gravity", "gravity"))


# -- a sheet from plain numbers


def test_a_sheet_from_plain_numbers_predicts():
    model = long_sheet()
    assert labrig.predict(model, "sheet", 0.01, 2.0).F_N > 0
    both = labrig.predict(model, "sheet", np.array([0.0, 0.01]), np.array([2.0, -2.0]))
    assert both.F_N.shape == (2,)
    assert repr(model).startswith("SheetModel: sheet")


def test_the_stiffness_may_be_a_modulus():
    by_E = long_sheet(B_Nm2=None, E_Pa=150e6)
    B = 150e6 * 11e-3 * 0.21e-3**3 / 12
    assert by_E.sheets["sheet"].B.value == pytest.approx(B)


def test_an_eibm_is_a_number_a_function_or_rows():
    def falling(s_m):
        return 80e-6 * np.exp(-s_m / 0.012)

    s_m = np.linspace(0.0, 0.05, 51)
    forces = [
        labrig.predict(long_sheet(EIBM_Nm={2.0: one}), "sheet", 0.01, 2.0).F_N
        for one in (falling, (s_m, falling(s_m)))
    ]
    assert forces[0] == pytest.approx(forces[1], rel=1e-9)
    rows = long_sheet(EIBM_Nm=(s_m, falling(s_m)))
    assert rows.sheets["sheet"].mean_eibm(-2.0) == pytest.approx(
        -rows.sheets["sheet"].mean_eibm(2.0)
    )


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"free_length_mm": 0.05}, r"free_length_mm: 0\.05 mm, wanted 1 to 300 mm"),
        ({"width_mm": -1}, "width_mm"),
        ({"B_Nm2": None}, "give either B_Nm2 or E_Pa"),
        ({"B_Nm2": -1e-6}, "the bending stiffness must be positive"),
        ({"B_Nm2": 1.27}, "which no solid has; 1.27 µN m² are 1.27e-06 N m²"),
        ({"B_Nm2": None, "E_Pa": 1e14}, "E_Pa = 1e\\+14: no solid has such"),
        ({"B_Nm2": None, "E_Pa": 1e-3}, "E_Pa = 0.001: no solid has such"),
        ({"EIBM_Nm": {0.0: 1e-6}}, "at 0 V there is none"),
        ({"EIBM_Nm": {2.0: ([0.0, 0.01], [1e-6])}}, "as many places as values"),
        ({"EIBM_Nm": {2.0: "large"}}, "must be a number in N m, a function of s_m, or a pair"),
    ],
)
def test_a_number_that_no_sheet_has_is_one_sentence(changes, said):
    with pytest.raises((BadInputError, ModelError), match=said) as error:
        long_sheet(**changes)
    assert len(str(error.value).split()) <= 25


# -- simulate


def test_simulate_takes_a_model_or_its_file_and_gives_arrays(model_file, capsys):
    printed = printed_json(
        capsys, "simulate", model_file, "--position-mm", 0, "--position-mm", 12, "--voltage", 2
    )
    found = labrig.simulate(str(model_file), position_mm=[0, 12], voltage=2)
    assert [one["F_N"] for one in printed] == [one.F_N for one in found]
    assert len(found) == 4
    assert found.to_dataframe().F_N.tolist() == [one.F_N for one in found]
    assert [one.configuration for one in found[:2]] == ["long", "long"]


def test_an_eibm_of_ones_own_takes_the_models_place(model_file, tmp_path, capsys):
    table = tmp_path / "eibm.csv"
    table.write_text("s_mm,Me_Nm\n0,8e-5\n25,1e-5\n50,0\n")
    at = ("--position-mm", 5, "--configuration", "long")
    printed = printed_json(capsys, "simulate", model_file, *at, "--eibm", f"2={table}")
    rows = ([0.0, 0.025, 0.05], [8e-5, 1e-5, 0.0])
    own = labrig.simulate(model_file, position_mm=5, configuration="long", eibm={2.0: rows})
    assert [one["F_N"] for one in printed] == [one.F_N for one in own]
    theirs = labrig.simulate(model_file, position_mm=5, configuration="long", voltage=2)
    assert pytest.approx(theirs[0].F_N, rel=1e-3) != own[0].F_N
    constant = printed_json(capsys, "simulate", model_file, *at, "--eibm", "2=4e-5")
    number = labrig.simulate(model_file, position_mm=5, configuration="long", eibm={2: 4e-5})
    assert constant[0]["F_N"] == number[0].F_N


@pytest.mark.slow
def test_sheet_toml_and_numbers_need_no_model_file(tmp_path, capsys):
    sheet = tmp_path / "sheet.toml"
    sheet.write_text(
        "free_length_mm = 50\nwidth_mm = 11\nthickness_mm = 0.21\ninitial_curvature_per_m = 0.0\n"
    )
    stated = ("--stiffness-Nm2", "1.27e-6", "--eibm", "2=36e-6", "--eibm", "-2=-36e-6")
    printed = printed_json(capsys, "simulate", sheet, "--position-mm", 10, *stated)
    forces = [labrig.predict(long_sheet(), "sheet", 0.01, v).F_N for v in (2.0, -2.0)]
    assert [one["F_N"] for one in printed] == pytest.approx(forces, rel=1e-12)
    designed = printed_json(capsys, "design", sheet, "--section", "0:20", *stated)
    assert designed[0]["work_of_a_cycle_J"]["value"] > 0


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--eibm", "36e-6"), "write --eibm 2=36e-6"),
        (("--eibm", "2=1e-6", "--eibm", "2.0=2e-6"), "is given twice"),
        (("--eibm", "0=1e-6"), "at 0 V there is none"),
        (("--eibm", "2=nowhere.csv"), "nowhere.csv"),
        (("--stiffness-Nm2", "1e-6"), "give the EIBM, too"),
    ],
)
def test_a_wrong_eibm_is_one_sentence(model_file, options, said, capsys):
    assert run(["simulate", str(model_file), "--position-mm", "5", *options]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert len(error.strip().splitlines()) == 1


def test_a_model_that_misses_its_data_is_named_in_a_warning(tmp_path):
    merit = {FORCE: 1e-3, CURVE: 2e-3, FORCE_SIZE: 2e-3}
    model = truth("long").with_merit(merit, {})
    with pytest.warns(labrig.LabrigWarning, match="misses its own data by 1.000 mN"):
        labrig.simulate(model, position_mm=0, voltage=2)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"position_mm": "5"}, "position_mm '5': a number is needed"),
        ({"position_mm": np.ones((2, 2))}, r"position_mm array.*: a number is needed"),
        ({"voltage": [2, None]}, "voltage None: a number is needed"),
        ({"eibm": {"2": 36e-6}}, "eibm '2': a number is needed"),
        ({"eibm": [36e-6]}, "EIBMs by voltage are needed, such as {2.0: 36e-6}"),
    ],
)
def test_a_wrong_type_is_one_sentence_of_simulate(options, said):
    with pytest.raises(BadInputError, match=said):
        labrig.simulate(long_sheet(), **({"position_mm": 5, "voltage": 2} | options))


def test_an_eibm_whose_places_are_in_mm_is_refused(tmp_path):
    rows = ([0, 25, 50], [36e-6, 20e-6, 10e-6])
    said = "reaches to s = 50 m, the sheet to 0.05 m; its places s are in m"
    with pytest.raises(labrig.ModelError, match=said):
        labrig.simulate(long_sheet(), position_mm=5, eibm={2.0: rows})
    with pytest.raises(labrig.ModelError, match=said):
        long_sheet(EIBM_Nm=rows)
    far = ([0, 0.3], [36e-6, 10e-6])  # straight lines end where they like
    assert len(labrig.simulate(long_sheet(), position_mm=5, eibm={2.0: far})) == 1


def test_simulate_asks_for_what_is_missing():
    with pytest.raises(BadInputError, match="at least one position_mm and one voltage"):
        labrig.simulate(long_sheet(), voltage=2)


# -- design


@pytest.mark.slow
def test_design_is_what_the_command_prints(model_file, capsys):
    printed = printed_json(
        capsys, "design", model_file, "--section", "0:20", "--configuration", "short"
    )
    found = labrig.design(model_file, (0, 20), configuration="short")
    assert found.to_json() == printed
    assert found[0].wanted.configuration == "short"
    assert len(repr(found).splitlines()) <= 24
    assert "7. short: quasi-static work" in "".join(found.to_dataframe().table.unique())


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"direction": "up"}, "direction: 'up' is not one of 'both', 'positive', 'negative'."),
        ({"mass_g": 0}, "mass_g 0: a number above 0 is needed."),
        ({"bandwidth_hz": -1}, "bandwidth_hz -1: a number above 0 is needed."),
        ({"force_mN": -1.5}, "force_mN -1.5: a number above 0 is needed."),
        ({"force_mN": "a"}, "force_mN 'a': a number is needed."),
        ({"lag_s": -1}, "lag_s -1: a number from 0 is needed."),
    ],
)
def test_a_wish_that_nobody_can_have_is_one_sentence(options, said):
    with pytest.raises(BadInputError) as told:
        labrig.design(long_sheet(), (0, 20), **options)
    assert str(told.value) == said


def test_a_map_asks_for_a_direction_that_there_is():
    with pytest.raises(BadInputError, match="'up' is not one of"):
        labrig.map_of_elongation(long_sheet(), (0, 20), configuration="long", direction="up")


def test_a_section_may_be_text_or_a_pair():
    with pytest.raises(BadInputError, match="such as 0:30"):
        labrig.design(long_sheet(), "0-30")
    with pytest.raises(BadInputError, match="such as 0:30"):
        labrig.design(long_sheet(), (0, 10, 20))


@pytest.mark.parametrize(
    ("guess", "said"),
    [
        (
            "open",
            (
                "did you mean load_measurements or load_model or load_optics or open_session or "
                "read_image or read_tables?"
            ),
        ),
        (
            "load",
            (
                "did you mean load_measurements or load_model or load_optics or open_session or "
                "read_image or read_tables?"
            ),
        ),
        ("verify", "on the command line it is `labrig verify`"),
        ("diagnoze", "did you mean diagnose?"),
        ("forces", "has no attribute 'forces'"),
    ],
)
def test_a_guessed_name_is_answered_with_those_alike(guess, said):
    with pytest.raises(AttributeError) as raised:
        getattr(labrig, guess)
    assert str(raised.value).endswith(said)


def test_the_figures_list_nothing_but_themselves():
    assert dir(labrig.plot) == labrig.plot.__all__


@pytest.mark.parametrize(
    ("data", "said"), [(None, "not None;"), (5, "not an int;"), (object(), "not an object;")]
)
def test_what_is_no_session_is_refused_with_what_is_needed(data, said):
    with pytest.raises(BadInputError, match=f"measurements are needed, {said}"):
        labrig.fit(data)


def test_a_data_frame_is_no_session():
    frame = pytest.importorskip("pandas").DataFrame({"force_N": [0.0]})
    with pytest.raises(BadInputError, match="not a DataFrame; for tables see"):
        labrig.diagnose(frame)


@pytest.mark.slow
def test_a_fit_is_no_model_and_its_models_are_named(fitted):
    with pytest.raises(BadInputError, match="not a Fit; a fit has three: preferred_model, model"):
        labrig.predict(fitted, "long", 0.0, 2.0)


def test_what_is_no_run_no_image_and_no_measurements_is_one_sentence(session_file, tmp_path):
    with labrig.open_session(session_file) as opened:
        with pytest.raises(BadInputError, match="run '0': an index is needed, from 0"):
            opened.run("0")
        with pytest.raises(BadInputError, match="none in row '0'"):
            opened.run(0).image("0")
        with pytest.raises(BadInputError, match="load_measurements returns is needed, not a str"):
            opened.to_xarray("session.h5")
    with pytest.raises(BadInputError, match="format: a text is needed, not None"):
        labrig.export(session_file, tmp_path / "tables", None)
    with pytest.raises(labrig.ModelError, match="measurements have no part"):
        labrig.load_measurements(session_file).to_dataframe(["curves"])


@pytest.mark.slow
def test_an_open_session_stands_for_its_file(session_file):
    with labrig.open_session(session_file) as opened:
        assert labrig.load_measurements(opened).conditions
        assert list(labrig.fit(opened).configurations) == ["long"]
