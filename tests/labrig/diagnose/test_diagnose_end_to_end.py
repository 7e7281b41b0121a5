"""From somebody's CSV tables to a model that lacks nothing, by the commands alone."""

from __future__ import annotations

import json

import pytest

from benchmarks.hidden_effects import case, hidden_session, write
from labrig.cli.main import run
from labrig.model_file import load_model
from labrig.session.tables.drive_table import load_protocol


def labrig(*arguments: object) -> int:
    return run([str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def imported(tmp_path_factory):
    """A session in which the EIBM falls along the sheet."""
    folder = tmp_path_factory.mktemp("hidden")
    hidden = hidden_session(case("nonuniform_eibm", seed=1))
    sheet, *tables = write(hidden, folder / "tables", folder / "truth.json")
    options = [part for path in tables for part in (f"--{path.stem}", path)]
    session = folder / "session.h5"
    assert labrig("import", "--sheet", sheet, *options, "-o", session) == 0
    return session


@pytest.mark.thorough
@pytest.mark.timeout(900)
def test_a_hidden_effect_is_named_added_and_then_nothing_is_missing(imported, tmp_path, capsys):
    model = tmp_path / "model+.toml"
    assert labrig("diagnose", imported, "-o", model, "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert found["verdict"] == "effect_named"
    assert [one["name"] for one in found["effects"]] == ["nonuniform_eibm"]
    held_out = found["gap"]["held_out"]
    for key in ("force_rmse_mN", "curve_rmse_mm"):
        assert held_out["after"][key] < 0.9 * held_out["before"][key]
    kept = tmp_path / "again.toml"
    assert labrig("diagnose", imported, "--model", model, "-o", kept, "--json") == 0
    again = json.loads(capsys.readouterr().out)
    assert (again["verdict"], again["effects"]) == ("nothing_missing", [])
    before, after = (load_model(path).effects for path in (model, kept))
    assert [one.name for one in after] == ["nonuniform_eibm"]
    one, two = (effects[0].parameters["decay_length_mm"].value for effects in (before, after))
    assert two == pytest.approx(one, rel=0.05)
    assert labrig("compare", imported, "--model", model, "--json") == 0
    rows = json.loads(capsys.readouterr().out)["static"]
    for name in ("long", "short"):
        own = {r["model"]: r for r in rows if r["configuration"] == name}
        best = own["full model, EIBM along the sheet"]["force_rmse_mN"]
        assert own["model+.toml"]["force_rmse_mN"] < 3.0 * best


@pytest.mark.thorough  # tests/labrig/python_api/test_functions.py asks for less data
@pytest.mark.timeout(900)
def test_next_proposes_something_that_the_protocol_knows(imported, tmp_path, capsys):
    path = tmp_path / "protocol.toml"
    names = ("initial_curvature", "clamp_angle")
    assert labrig("next", imported, "--between", *names, "-o", path) == 0
    assert " sigma" in capsys.readouterr().out
    assert load_protocol(path).schedule(str(path)).runs
