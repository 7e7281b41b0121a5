"""`labrig compare` in time: a session of a sheet that moves, the models beside one another."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.end_to_end.small_rig import labrig, make_rig, run_rig, two_positions
from tests.labrig.moving_session import moving_session
from tests.made_once import made_once

PROTOCOL = """
[pulse_train]
zero_readings = 1
pulses_discarded = 1
readings_per_voltage = 1

[[places]]
configuration = "long"
positions_mm = [5, 15]

[extras]
free_shapes = false
reversed_approach = false
no_touch_zero = false
random_order = false
[extras.release]
rest_s = 1.0
swing_s = 1.0
"""
WORLD = Path(__file__).parents[2] / "sim_hardware" / "world" / "moving.toml"

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("data_unchecked")]


@pytest.fixture
def compared(tmp_path_factory):
    """A folder with the session and what `compare --dynamic --json` printed of it."""

    def make(folder):
        session = run_rig(make_rig(folder, PROTOCOL, WORLD.read_text()))
        assert labrig("analyze", session) == 0

    return made_once(tmp_path_factory, "compared-in-time", make)


@pytest.mark.timeout(900)
@pytest.mark.thorough
def test_the_moving_sheet_predicts_best_and_the_report_shows_it(compared, tmp_path, capsys):
    session = tmp_path / "session.h5"
    session.write_bytes((compared / "session.h5").read_bytes())
    assert labrig("report", session, "-o", tmp_path / "before", "--format", "svg") == 0
    assert "keeps the result for this page" in (tmp_path / "before/index.html").read_text()
    capsys.readouterr()
    assert labrig("compare", session, "--dynamic", "--json") == 0
    told = capsys.readouterr()
    assert "compare in time" in told.err  # progress
    found = json.loads(told.out)
    assert found["static"] == []
    (table,) = found["dynamic"]
    models = {one["name"]: one for one in table["models"]}
    assert len(models) == 10
    full = table["models"][0]
    assert full["name"] == "full"
    for quantity, noise in (("force", 1.3e-4), ("current", 7e-5), ("shape", 2e-4)):
        mine = full["quantities"][quantity]
        assert mine["rmse"] < noise
        for name, one in models.items():
            other = one["quantities"].get(quantity)
            if other is not None and name != "full":
                # after Pugal: the same electrodes, so the same current but for the priors
                same = (quantity, name) == ("current", "pugal")
                assert mine["ln_evidence"] > other["ln_evidence"] - 5.0 * same
    assert full["parameters"]["B"] == pytest.approx(1.27e-6, rel=0.03)
    assert full["parameters"]["mass_per_length"] == pytest.approx(5.775e-3, rel=0.1)
    assert set(models["huynh_alici"]["quantities"]) == {"force"}
    assert models["yim"]["quantities"]["current"]["misfit"] > 10.0  # it has no leak
    assert labrig("report", session, "-o", tmp_path / "after", "--format", "svg") == 0
    page = (tmp_path / "after/index.html").read_text()
    assert "moving sheet of large deflections (labrig)" in page
    assert "after Lee, Park and Kim 2005" in page


@pytest.mark.thorough
def test_at_rest_alone_is_a_choice(tmp_path_factory, tmp_path, capsys):
    session = tmp_path / "session.h5"
    session.write_bytes(moving_session(tmp_path_factory).read_bytes())
    assert labrig("compare", session, "--static") == 0
    told = capsys.readouterr().out
    assert "linear beam" in told
    assert "in time" not in told


@pytest.mark.thorough
def test_without_a_moving_free_sheet_one_sentence_says_what_to_record(
    tmp_path_factory, tmp_path, capsys
):
    session = tmp_path / "session.h5"
    session.write_bytes(two_positions(tmp_path_factory).read_bytes())
    assert labrig("compare", session) == 0
    told = capsys.readouterr().out
    assert "linear beam" in told
    assert "Models in time were not compared for 'long': no free sheet that moves was" in told
    assert labrig("compare", session, "--dynamic") == 2
    assert "add [extras] release = true" in capsys.readouterr().err
    assert labrig("compare", session, "--dynamic", "--static") == 2
    assert "give --static or --dynamic" in capsys.readouterr().err
