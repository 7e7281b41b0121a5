"""The commands that evaluate a session: what they print, write and refuse."""

from __future__ import annotations

import json

import numpy as np
import pytest

from labrig.cli.main import run
from labrig.errors import BadInputError
from labrig.model_file import load_model, model_text, save_model
from labrig.session import open_session
from model import predict
from tests.labrig.report_data import STIFFNESS, invalid, measure, session, stopped_session, truth

pytestmark = pytest.mark.usefixtures("data_unchecked")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    return session(tmp_path_factory.mktemp("evaluate") / "made.h5", measure())


@pytest.fixture(scope="module")
def model_path(tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "model.toml"
    save_model(truth(), path)
    return path


def printed(capsys):
    captured = capsys.readouterr()
    return captured.out, captured.err


@pytest.mark.slow
def test_fit_writes_a_model_that_predicts_like_the_sheet(recorded, tmp_path, capsys):
    path = tmp_path / "model.toml"
    assert run(["fit", str(recorded), "-o", str(path), "--varying"]) == 0
    out, _ = printed(capsys)
    assert "bending stiffness B" in out
    assert "90 % intervals reach" in out
    assert f"wrote {path}" in out
    model = load_model(path)
    assert model.checksum == "ab" * 32
    found, wanted = predict(model, "long", 0.01, 2.0), predict(truth(), "long", 0.01, 2.0)
    assert pytest.approx(wanted.F_N, rel=0.05) == found.F_N


@pytest.mark.thorough
@pytest.mark.slow
def test_fit_writes_the_model_that_describes_the_data_unless_told_otherwise(
    recorded, tmp_path, capsys
):
    path = tmp_path / "model.toml"
    assert run(["fit", str(recorded), "-o", str(path)]) == 0
    out, err = printed(capsys)
    assert f"{path} holds the EIBM along the sheet" in out
    assert "misses its own data" not in err
    assert len(load_model(path).sheet("long").eibm[2.0].s_m) > 1
    assert run(["fit", str(recorded), "-o", str(path), "--force", "--constant"]) == 0
    out, err = printed(capsys)
    assert "holds the EIBM along the sheet" not in out
    assert "warning: the model of 'long' misses its own data by" in err
    assert len(load_model(path).sheet("long").eibm[2.0].s_m) == 1
    assert run(["simulate", str(path), "--position-mm", "10", "--voltage", "2"]) == 0
    assert "the model of 'long' misses its own data by" in printed(capsys)[1]


@pytest.mark.slow
def test_fit_json_is_one_object_of_the_documented_shape(recorded, capsys):
    assert run(["fit", str(recorded), "--json", "--q", "0"]) == 0
    found = json.loads(printed(capsys)[0])
    assert set(found) == {"configurations", "data_checks", "rmse"}
    assert set(found["rmse"]) == {"force_mN", "curve_mm"}
    for name, B in STIFFNESS.items():
        one = found["configurations"][name]
        assert set(one) == {"B_Nm2", "E_Pa", "EIBM_Nm", "EIBM_along_sheet"}
        assert one["B_Nm2"]["value"] == pytest.approx(B, rel=0.05)
        assert set(one["EIBM_along_sheet"]["2.0"]) == {"s_mm", "Me_Nm", "sigma"}


@pytest.mark.thorough
@pytest.mark.slow
def test_fit_does_not_overwrite_a_model_unless_told_to(recorded, tmp_path, capsys):
    path = tmp_path / "model.toml"
    path.write_text("mine")
    assert run(["fit", str(recorded), "-o", str(path)]) == 2
    assert "give --force to overwrite it" in printed(capsys)[1]
    assert path.read_text() == "mine"
    assert run(["fit", str(recorded), "-o", str(path), "--force"]) == 0
    assert load_model(path).sheets


@pytest.mark.parametrize("name", ["model.json", "model"])
@pytest.mark.parametrize("command", [["fit"], ["fit", "--dynamic"], ["diagnose"]])
def test_a_model_is_not_written_under_the_name_of_another_kind_of_file(
    tmp_path, capsys, command, name
):
    path = tmp_path / name
    assert run([*command, "session.h5", "-o", str(path)]) == 2
    assert f"{path}: a model file is TOML; name it model.toml." in printed(capsys)[1]
    assert not path.exists()
    with pytest.raises(BadInputError, match=r"name it model\.toml"):
        save_model(truth(), path)


@pytest.mark.slow
def test_fit_of_a_session_without_valid_readings_is_one_sentence(tmp_path, capsys):
    stuck = invalid(measure("long"), "long", "the sheet stuck")
    path = session(tmp_path / "made.h5", stuck)
    assert run(["fit", str(path), "-o", str(tmp_path / "model.toml")]) == 2
    _, err = printed(capsys)
    assert "the sheet stuck" in err
    assert "Traceback" not in err
    assert not (tmp_path / "model.toml").exists()


@pytest.mark.thorough
@pytest.mark.slow
def test_fit_leaves_out_and_names_a_configuration_that_cannot_be_fitted(tmp_path, capsys):
    path = session(tmp_path / "made.h5", invalid(measure(), "short", "the sheet stuck"))
    assert run(["fit", str(path), "--json"]) == 0
    out, err = printed(capsys)
    assert list(json.loads(out)["configurations"]) == ["long"]
    assert "short: could not be fitted" in err


@pytest.mark.slow
def test_fit_refuses_a_negative_weight_exponent(recorded, capsys):
    assert run(["fit", str(recorded), "--q", "-1"]) == 2
    assert "q must not be negative" in printed(capsys)[1]


@pytest.mark.slow
def test_fit_analyses_a_session_that_was_not_and_says_so(tmp_path, capsys):
    path = stopped_session(tmp_path / "half.h5", after_runs=1)
    run(["fit", str(path)])
    assert "not analysed yet" in printed(capsys)[1]
    with open_session(path) as opened:
        assert opened.has_measurements


@pytest.mark.thorough
@pytest.mark.slow
def test_analyze_keeps_what_it_found_in_the_session(tmp_path, capsys):
    path = stopped_session(tmp_path / "half.h5", after_runs=1)
    assert run(["analyze", str(path), "--json"]) == 0
    found = json.loads(printed(capsys)[0])
    assert {c["configuration"] for c in found["conditions"]} == {"long"}
    assert all(c["curve"] is None for c in found["conditions"])
    assert any("optics.json" in text for text in found["warnings"])
    with open_session(path) as opened:
        assert opened.has_measurements
    assert run(["analyze", str(path)]) == 0
    out, _ = printed(capsys)
    assert "long, 0 mm, +2 V" in out


@pytest.mark.thorough
@pytest.mark.slow
def test_analyze_of_a_session_without_runs_is_one_sentence(tmp_path, capsys):
    path = stopped_session(tmp_path / "none.h5", after_runs=0)
    assert run(["analyze", str(path)]) == 2
    assert "nothing to analyze" in printed(capsys)[1]


@pytest.mark.slow
def test_simulate_answers_all_combinations(model_path, capsys):
    arguments = ["simulate", str(model_path), "--json", "--configuration", "long"]
    for position in ("0", "5", "60"):
        arguments += ["--position-mm", position]
    for volts in ("2", "-2"):
        arguments += ["--voltage", volts]
    assert run(arguments) == 0
    found = json.loads(printed(capsys)[0])
    assert [(one["position_mm"], one["voltage_V"]) for one in found] == [
        (p, v) for p in (0.0, 5.0, 60.0) for v in (2.0, -2.0)
    ]
    assert found[0]["reachable"]
    assert found[0]["F_N"] == pytest.approx(predict(truth(), "long", 0.0, 2.0).F_N)
    assert len(found[0]["x_mm"]) == len(found[0]["y_mm"]) == len(found[0]["curvature_per_m"])
    assert not found[5]["reachable"]
    assert found[5]["F_N"] is None
    assert "slips out" in found[5]["why"]


def test_simulate_takes_every_configuration_when_none_is_named(model_path, capsys):
    assert run(["simulate", str(model_path), "--position-mm", "5", "--voltage", "2"]) == 0
    out, _ = printed(capsys)
    assert "long" in out
    assert "short" in out


@pytest.mark.parametrize(
    ("extra", "said"),
    [
        (["--voltage", "2"], "at least one --position-mm"),
        (["--position-mm", "5"], "at least one --position-mm"),
        (["--position-mm", "5", "--voltage", "3"], "+3 V is outside"),
        (
            ["--position-mm", "5", "--voltage", "2", "--session", "2"],
            "--session 2: the model has nothing that differs between sessions.",
        ),
        (
            ["--position-mm", "5", "--voltage", "2", "--configuration", "wide"],
            "no configuration 'wide'",
        ),
    ],
)
def test_simulate_refuses_what_the_model_cannot_answer(model_path, capsys, extra, said):
    assert run(["simulate", str(model_path), *extra]) == 2
    assert said in printed(capsys)[1]


@pytest.mark.slow
def test_report_says_where_the_page_is(tmp_path, capsys):
    small = stopped_session(tmp_path / "small.h5", after_runs=0)
    assert run(["report", str(small), "-o", str(tmp_path / "out")]) == 0
    page = tmp_path / "out" / "index.html"
    assert f"wrote {page}" in printed(capsys)[0]
    assert page.exists()


def test_a_model_file_holds_its_parameters_to_the_last_bit(tmp_path):
    model = truth()
    path = tmp_path / "model.toml"
    save_model(model, path)
    again = load_model(path)
    for name, one in model.sheets.items():
        assert again.sheets[name].B == one.B
        for volts, along in one.eibm.items():
            assert np.array_equal(again.sheets[name].eibm[volts].values, along.values)
            assert np.array_equal(again.sheets[name].eibm[volts].s_m, along.s_m)
    ours, theirs = predict(model, "short", 0.02, -2.0), predict(again, "short", 0.02, -2.0)
    assert pytest.approx(ours.F_N, rel=1e-12) == theirs.F_N
    assert [item.name for item in tmp_path.iterdir()] == ["model.toml"]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "labrig_model = 1",
            "labrig_model = 7",
            "has format 7 and this labrig reads formats 1 and",
        ),
        ("labrig_model = 1", "labrig_model = 0", "not a model file of format 1"),
        ("labrig_model = 1", 'labrig_model = "7"', "not a model file of format 1"),
        ("width_mm = 11.0", "width_mm = -1.0", "configurations.long.geometry.width_mm"),
        (
            "[configurations.long.B_Nm2]\nvalue",
            "[configurations.long.B_Nm2]\nvolume",
            "B_Nm2.value",
        ),
        ("width_mm = 11.0", "width_mm = ", "not valid TOML"),
    ],
)
def test_a_bad_model_file_is_refused_with_file_and_key(tmp_path, old, new, said):
    path = tmp_path / "model.toml"
    text = model_text(truth())
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(BadInputError, match=r"model\.toml") as error:
        load_model(path)
    assert said in str(error.value)


def test_a_model_file_that_cannot_be_written_is_one_sentence(tmp_path):
    with pytest.raises(BadInputError, match="there is no such folder"):
        save_model(truth(), tmp_path / "nowhere" / "model.toml")


@pytest.mark.thorough
def test_compare_shows_what_large_deflection_and_a_varying_eibm_are_worth(recorded, capsys):
    assert run(["compare", str(recorded), "--json"]) == 0
    told = json.loads(printed(capsys)[0])
    rows = told["static"]
    assert told["dynamic"] == []
    assert "no current was recorded" in told["why_no_dynamic"]["long"]
    errors = {(row["configuration"], row["model"]): row["curve_rmse_mm"] for row in rows}
    assert errors["long", "linear beam"] > 1.0
    assert errors["long", "full model, EIBM along the sheet"] < 0.1
    assert run(["compare", str(recorded)]) == 0
    assert "short: constant curvature" in printed(capsys)[0]
