"""labrig fit --dynamic and next --dynamic, on a session recorded in the moving world."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import labrig
from labrig.analysis.comparison import compare_fitted
from labrig.analysis.motion import dynamic_fit as fit_module
from labrig.analysis.motion import motion_record
from labrig.analysis.motion.beginning import StatedValues, beginning
from labrig.analysis.motion.dynamic_fit import NoSheetInTimeError, dynamic_fit
from labrig.api import fit_in_time as fitting
from labrig.api import motion_data
from labrig.api.fit_in_time import doubts
from labrig.api.motion_data import fits_of, request_of, spread
from labrig.cli.main import run
from labrig.errors import BadInputError, LabrigWarning
from labrig.model_file import load_model
from labrig.session import add_mark, open_session
from labrig.session.marks.mark import Mark
from model.dynamics.identification import fit as identify_module
from model.dynamics.identification import search as search_module
from model.dynamics.identification.parameters import LogParameters
from tests.labrig.moving_session import TRUTH, moving_session
from tests.labrig.report_data import measure, session

# a session is recorded, measured and fitted: half a minute of CPU
pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(1200),
    pytest.mark.usefixtures("data_unchecked"),
]

WANTED = dict(zip(
    [one.name for one in LogParameters(TRUTH).quantities], np.exp(LogParameters(TRUTH).theta),
    strict=True,
))  # fmt: skip
# what a step of the links, a curve's bias and a millisecond of the world are worth
BEYOND_NOISE = 0.01


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return moving_session(tmp_path_factory)


@pytest.fixture(scope="module")
def fits(path):
    return fits_of(request_of(path, (), (), "air", None), None)


@pytest.fixture
def fitted(monkeypatch, fits):
    """The commands' own search, done once."""
    monkeypatch.setattr(fitting, "fits_of", lambda _request, _progress: fits)


@pytest.fixture(scope="module")
def model(fits, path, tmp_path_factory):
    file = tmp_path_factory.mktemp("model") / "model.toml"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fitting, "fits_of", lambda _request, _progress: fits)
        assert run(["fit", str(path), "--dynamic", "-o", str(file)]) == 0
    return file


def refusal(capsys, *arguments: object) -> str:
    assert run([str(one) for one in arguments]) == 2
    err = capsys.readouterr().err.strip().splitlines()[-1]
    assert "Traceback" not in err
    return err


def test_the_sheet_of_the_world_is_found_with_its_intervals(fits):
    (fit,) = fits
    assert fit.found.converged
    assert fit.found.undetermined == ()
    for one in fit.found.parameters:
        away = abs(np.log(one.parameter.value / WANTED[one.name]))
        assert away < 3.0 * one.log_sigma + BEYOND_NOISE, one.name
        assert one.prior_share < 0.25
    assert fit.found["B"].log_sigma < 0.01
    assert fit.found["mass_per_length"].log_sigma < 0.01
    assert fit.noise.force.white == pytest.approx(1.2e-4, rel=0.1)
    assert fit.noise.curve_m < 3e-5


def test_the_table_names_value_interval_and_prior_and_which_stiffness_it_is(fitted, path, capsys):
    assert run(["fit", str(path), "--dynamic"]) == 0
    out = capsys.readouterr().out
    for text in (
        "relaxed bending stiffness B",
        "90 % interval",
        "prior's share",
        "Prony time 2",
        "B is the relaxed stiffness",
        "labrig fit without --dynamic",
        "Noise, from what",
    ):
        assert text in out  # fmt: skip


def test_json_holds_the_same_in_si(fitted, fits, path, capsys):
    assert run(["fit", str(path), "--dynamic", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["configurations"]["long"]
    assert found["B_is"] == "relaxed"
    B = found["parameters"]["B"]
    assert B["value"] == pytest.approx(fits[0].found["B"].parameter.value)
    assert B["interval90"][0] < B["value"] < B["interval90"][1]
    assert B["determined"] is True
    assert found["undetermined"] == []
    assert found["chi2_per_value"] == pytest.approx(1.0, abs=0.2)


@pytest.mark.thorough
def test_the_model_file_is_what_the_commands_in_time_read(model, capsys):
    known = load_model(model)
    beam, rolls = known.moving("long", 0.005)
    assert beam.material.B_Nm2 == pytest.approx(WANTED["B"], rel=0.03)
    assert rolls.radius_m == pytest.approx(0.04)
    table = known.dynamic["long"].to_dict()
    assert table["mass_per_length_kg_per_m"]["determined_by"] == "data"
    assert table["source_ohm"]["determined_by"] == "stated"
    assert table["prony"][0]["share"]["determined_by"] == "data"
    assert run(["response", str(model), "--position-mm", "5", "-o", str(model.parent / "r")]) == 0
    at_2_V = ["--configuration", "long", "--position-mm", "5", "--voltage", "2", "--json"]
    capsys.readouterr()
    assert run(["simulate", str(model), *at_2_V]) == 0
    force_N = json.loads(capsys.readouterr().out)[0]["F_N"]
    assert 1e-3 < force_N < 4e-3


@pytest.mark.thorough
def test_the_same_in_python_fits_a_screen_and_a_data_frame(fitted, fits, path, tmp_path):
    found = labrig.fit_in_time(str(path))
    assert len(repr(found).splitlines()) <= 24
    assert "relaxed bending stiffness B" in repr(found)
    frame = found.to_dataframe()
    B = frame[frame.parameter == "B"].iloc[0]
    assert B.value == fits[0].found["B"].parameter.value
    assert B.low90 < B.value < B.high90
    labrig.save_model(found.model, tmp_path / "dynamic.toml")
    assert load_model(tmp_path / "dynamic.toml").moving("long", 0.005)
    offered = labrig.next_in_time([path], model=found.model)
    assert len(repr(offered).splitlines()) <= 24
    assert "release" in repr(offered)
    rows = offered.to_dataframe()
    assert set(rows.run) == {"now", "release", "chirp", "load-cell step", "position 15 mm"}


def test_what_is_known_now_is_what_the_fit_of_the_stated_model_says(fits, model, path):
    rows = labrig.next_in_time(path, model=str(model)).to_dataframe()
    now = rows[rows.run == "now"].set_index("parameter")
    for one in fits[0].found.parameters:
        ratio = now.sigma[one.name] / one.parameter.sigma
        assert 0.6 < ratio < 1.3, one.name  # what is known now stands for all samples by a few


def test_an_unknown_fluid_is_one_sentence(path):
    with pytest.raises(BadInputError, match=r"fluid: .oil. is not one of .air., "):
        labrig.fit_in_time(path, fluid="oil")


def test_a_stated_file_is_not_overwritten(model, path, capsys):
    assert "is already there" in refusal(capsys, "fit", path, "--dynamic", "-o", model)


@pytest.mark.thorough
def test_next_says_that_a_release_determines_mass_and_loss(model, path, tmp_path, capsys):
    copy = tmp_path / "session.h5"
    copy.write_bytes(path.read_bytes())
    add_mark(copy, Mark(run=0, reading=None, why="the sheet was touched", who="Ann"))
    capsys.readouterr()
    assert run(["next", str(copy), "--dynamic", "--model", str(model), "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["configurations"]["long"]
    by_run = {row["run"]: row["parameters"] for row in rows}
    assert set(by_run) == {"now", "release", "chirp", "load-cell step", "position 15 mm"}
    for name in ("mass_per_length", "share_2", "time_2"):
        assert not by_run["now"][name]["determined"]
        assert by_run["release"][name]["determined"]
        assert not by_run["chirp"][name]["determined"]
    assert by_run["now"]["B"]["determined"]
    for found in by_run.values():
        assert found["capacitance"]["sigma"] <= by_run["now"]["capacitance"]["sigma"]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--dynamic", "--q", "2"], "labrig fit --dynamic does not go with --q"),
        (["--dynamic", "--varying"], "does not go with --varying or --constant"),
        (["--position-mm", "5"], "--position-mm is for the sheet in time: give --dynamic"),
        (["--fluid", "water"], "--fluid is for the sheet in time"),
        (["--dynamic", "--position-mm", "7"], "was measured at 5 mm"),
        (["--dynamic", "--configuration", "short"], "no whole run of 'short' was driven"),
        (["--dynamic", "--elongation-g-per-m", "-1"], "a number above 0 is needed"),
    ],
)
def test_options_that_cannot_be_followed_are_refused_in_a_sentence(path, capsys, arguments, says):
    assert says in refusal(capsys, "fit", path, *arguments)


def test_a_session_without_a_current_is_refused(tmp_path, capsys):
    silent = session(tmp_path / "silent.h5", measure("long"))
    assert "no current of the sheet was recorded" in refusal(capsys, "fit", silent, "--dynamic")


def test_a_sheet_whose_elongation_is_not_stated_is_left_out_before_anything_is_read(
    tmp_path, capsys
):
    both = session(tmp_path / "both.h5", measure("long", "short"))
    asked = refusal(capsys, "fit", both, "--dynamic", "--configuration", "short")
    assert "'short' has an elongation" in asked
    assert "--elongation-g-per-m" in asked
    assert run(["fit", str(both), "--dynamic"]) == 2
    told = capsys.readouterr().err
    assert "'short' is left out" in told
    assert "no current of the sheet was recorded" in told.strip().splitlines()[-1]  # the long one


def test_what_only_the_user_knows_is_asked_for(path):
    with open_session(path) as opened:
        record = motion_record(opened, frames=False)
    longer = replace(record.sheet, elongation_m=0.04)
    with pytest.raises(BadInputError, match="state it with elongation_g_per_m"):
        beginning(longer, record.runs, StatedValues())
    unknown = replace(record.sheet, initial_curvature=None)
    with pytest.raises(BadInputError, match="no free sheet was filmed at rest"):
        beginning(unknown, record.runs, StatedValues())


def test_few_positions_are_chosen_evenly():
    assert spread([0.0, 1.0, 2.0, 3.0, 4.0], 3) == [0.0, 2.0, 4.0]
    assert spread([1.0], 3) == [1.0]


def test_a_fit_that_leaves_more_than_the_noise_explains_is_not_to_be_trusted(fits):
    assert list(doubts(fits[0])) == []
    found = replace(fits[0].found, chi2=2.0 * fits[0].found.count)
    (doubt,) = doubts(replace(fits[0], found=found))
    assert "leaves 2.0 times the squares that the noise explains" in doubt


@pytest.mark.thorough
def test_a_sheet_that_was_not_found_is_left_out_or_refused(path, fits, monkeypatch):
    bad = NoSheetInTimeError("long: no sheet in time explains the session.")
    request = request_of(path, (), (), "air", None)
    progress: list[tuple[float, str]] = []

    def fitted(*_records, **_options):
        one = next(some)
        if one is bad:
            raise bad
        return one

    monkeypatch.setattr(motion_data, "dynamic_fit", fitted)
    monkeypatch.setattr(motion_data, "motion_record", read_once(motion_data.motion_record))
    monkeypatch.setattr(motion_data, "_determinable", lambda *_: ("long", "long"))
    some = iter([bad, fits[0]])
    with pytest.warns(LabrigWarning, match="left out: long: no sheet in time explains"):
        assert fits_of(request, lambda share, text: progress.append((share, text))) == [fits[0]]
    shares = [share for share, _ in progress]
    assert shares == sorted(shares)  # of both configurations together
    assert min(shares) < 0.2
    assert 0.5 < max(shares) <= 1.0
    some = iter([bad, bad])
    with pytest.raises(BadInputError, match="no sheet in time explains"):
        fits_of(request, None)


def test_where_curves_are_far_off_and_the_search_does_not_end_other_electrodes_are_not_tried(
    path, fits, monkeypatch
):
    """They took five minutes of a pseudo-random sequence, to say the same."""
    with open_session(path) as opened:
        record = motion_record(opened, frames=False)
    poor = replace(fits[0].noise, curve_m=1.2e-3)
    monkeypatch.setattr(fit_module, "_near", lambda beam, *_: (beam, None))
    monkeypatch.setattr(fit_module, "noise_of_residuals", lambda *_: poor)
    monkeypatch.setattr(search_module, "MOST_STEPS", 1)
    monkeypatch.setattr(identify_module, "other_electrodes", pytest.fail)
    with pytest.raises(
        NoSheetInTimeError, match=r"1\.20 mm off the fitted sheet\. Record a free release"
    ):
        dynamic_fit([record], StatedValues(), fits[0].found.beam)


def read_once(read):
    """What reads a session's motion, the first time: its images take more than a second."""
    kept = []

    def again(*given, progress, **options):
        if not kept:
            kept.append(read(*given, progress=progress, **options))
        elif progress is not None:
            progress(1.0, "read before")
        return kept[0]

    return again


@pytest.mark.thorough
def test_models_of_others_are_ranked_beside_a_fit_that_is_there(fits):
    found = compare_fitted(fits[0], names=("lee", "huynh_alici"))
    assert [one.name for one in found.models] == ["full", "lee", "huynh_alici"]
    full, lee, lag = found.models
    assert full.ln_evidence > lee.ln_evidence > lag.ln_evidence
    assert set(lag.quantities) == {"force"}
    assert full.quantities["force"].rmse < 0.8 * lag.quantities["force"].rmse
    assert full.quantities["shape"].rmse < 0.1 * lee.quantities["shape"].rmse
    assert "last third of the pulses" in found.held_out
