"""`compare --model`: a model file beside the models that are fitted."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from labrig.cli.main import run
from labrig.model_file import save_model
from labrig.report.tables.model_file import model_rows
from model.parameter import Parameter
from model.sheet.beam_problem import ActiveEffect
from tests.labrig.diagnose.made import constant, named_effect
from tests.labrig.report_data import measure, session, truth


def test_the_true_model_is_nearer_than_one_with_its_mean_eibm():
    measurements, model = measure("long"), truth("long")
    (true,) = model_rows(measurements, model, "true", ["long"])
    (mean,) = model_rows(measurements, constant(model), "mean", ["long"])
    (mended,) = model_rows(
        measurements, constant(model).with_effects(named_effect()), "mended", ["long"]
    )
    assert true.force_rmse_N < 2e-5
    assert true.curve_rmse_m < 5e-6
    assert mean.force_rmse_N > 3e-4
    assert mended.force_rmse_N == pytest.approx(true.force_rmse_N, abs=1e-5)


def test_simulate_says_which_effects_a_prediction_at_rest_leaves_out(tmp_path, capsys):
    lacks = {
        name: Parameter(value=value, sigma=0.0, unit="")
        for name, value in (("relative_deficit", 0.1), ("ratio", 0.2))
    }
    pulses = ActiveEffect(name="first_pulse_transient", parameters=lacks)
    model = replace(constant(truth("long")), merit={"force_rmse_N": 7.5e-5})
    asked = ["--position-mm", "12", "--voltage", "2"]
    for effects, told in (((named_effect(), pulses), True), ((named_effect(),), False)):
        path = tmp_path / f"{len(effects)}.toml"
        save_model(model.with_effects(*effects), path)
        assert run(["simulate", str(path), *asked]) == 0
        out = " ".join(capsys.readouterr().out.split())
        assert "long 0.075 mN" in out
        assert ("leaves out what changes along a run (first pulse transient)" in out) is told


def test_simulate_says_that_forces_are_those_that_the_load_cell_shows(tmp_path, capsys):
    """A zero of the load cell was taken for the sheet's force."""
    zero = Parameter(value=0.2, sigma=0.0, unit="mN")
    offset = ActiveEffect(name="force_offset", parameters={"force_mN": zero})
    asked = ["--position-mm", "12", "--voltage", "2"]
    for effects, told in (((named_effect(), offset), True), ((named_effect(),), False)):
        path = tmp_path / f"{len(effects)}.toml"
        save_model(constant(truth("long")).with_effects(*effects), path)
        assert run(["simulate", str(path), *asked]) == 0
        out = " ".join(capsys.readouterr().out.split())
        assert ("what load cell and camera show, with force offset;" in out) is told


@pytest.mark.thorough
@pytest.mark.slow
def test_compare_lists_a_model_file_with_the_fitted_ones(tmp_path, capsys):
    measurements = measure("long", positions_m=(0.0, 0.015, 0.03))
    path = session(tmp_path / "made.h5", measurements)
    save_model(constant(truth("long")).with_effects(named_effect()), tmp_path / "model+.toml")
    assert run(["compare", str(path), "--model", str(tmp_path / "model+.toml"), "--json"]) == 0
    rows = {row["model"]: row for row in json.loads(capsys.readouterr().out)["static"]}
    assert rows["model+.toml"]["force_rmse_mN"] < 0.03
    one = truth("long").sheet("long")
    other = replace(one, sheet=replace(one.sheet, free_length_m=0.07))
    save_model(replace(truth("long"), sheets={"long": other}), tmp_path / "other.toml")
    assert run(["compare", str(path), "--model", str(tmp_path / "other.toml")]) == 2
    assert "a free length of 70 mm" in capsys.readouterr().err
