"""A fourth channel is a table of rig.toml: it is recorded, shown, analysed, exported, resumed."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from labrig.config import parse_rig
from labrig.errors import BadInputError
from labrig.session import open_session, verify
from tests.end_to_end.small_rig import labrig, make_rig, run_rig

pytestmark = pytest.mark.slow
PROTOCOL = """
[pulse_train]
zero_readings = 1
readings_per_voltage = 1
pulses_discarded = 0
[[places]]
configuration = "long"
positions_mm = [10]
[extras]
mode = "paper"
"""
# Nothing is wired to ai3, so it reads 0 V but for the board's noise.
CHANNELS = """
[channels.temperature]
input = "PCI6034E/ai3"
quantity = "temperature"
unit = "degC"
gain = 100.0
offset = 21.5
range_V = 5.0
"""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = make_rig(tmp_path_factory.mktemp("channels") / "rig", PROTOCOL)
    rig = folder / "rig.toml"
    rig.write_text(rig.read_text() + CHANNELS)
    return run_rig(folder)


def test_further_channels_are_recorded_raw_and_in_every_reading(recorded: Path) -> None:
    assert all(check.ok for check in verify(recorded))
    with open_session(recorded) as session:
        assert session.channels == ("force", "current", "drive", "temperature")
        run = session.runs[0]
        np.testing.assert_allclose(run.signal_V("temperature"), 0.0, atol=0.01)
        np.testing.assert_allclose(run.readings["temperature_degC"], 21.5, atol=1.0)


def test_further_channels_are_shown(recorded: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert labrig("show", recorded, "--json") == 0
    channels = json.loads(capsys.readouterr().out)["channels"]
    found = {channel["name"]: channel for channel in channels}["temperature"]
    assert (found["quantity"], found["unit"]) == ("temperature", "degC")
    assert found["least"] == pytest.approx(21.5, abs=1.0)
    assert labrig("show", recorded) == 0
    assert "temperature" in capsys.readouterr().out


@pytest.mark.thorough
def test_further_channels_are_exported(recorded: Path, tmp_path: Path) -> None:
    assert labrig("analyze", recorded) == 0
    assert labrig("export", recorded, "-o", tmp_path / "tables") == 0
    with (tmp_path / "tables" / "forces.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert rows
    for row in rows:
        assert float(row["channel_temperature_degC"]) == pytest.approx(21.5, abs=1.0)


@pytest.mark.thorough
def test_a_session_with_further_channels_is_replayed(recorded: Path, tmp_path: Path) -> None:
    assert labrig("replay", recorded, "-o", tmp_path / "again.h5") == 0
    with open_session(recorded) as old, open_session(tmp_path / "again.h5") as new:
        now, then = (s.runs[0].readings["temperature_degC"] for s in (new, old))
        np.testing.assert_allclose(now, then, atol=1.0)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            '[channels.t]\ninput = "PCI6034E/ai2"\nquantity = "x"\nunit = "N"\n',
            r"PCI6034E/ai2 is the input of both drive and t",
        ),
        (
            '[channels.force]\ninput = "D/ai3"\nquantity = "x"\nunit = "N"\n',
            "'force' is a channel that every rig has",
        ),
        (
            '[channels.t]\ninput = "D ai3"\nquantity = "x"\nunit = "N"\n',
            "words of the boards",
        ),
        ('[channels.t]\ninput = "D/ai3"\nquantity = "x"\nunit = "m/s"\n', "letters, digits and _"),
        ('[channels.t]\ninput = "D/ai3"\nquantity = "x"\nunit = "N"\ngain = 0\n', "gain = 0"),
        ('[channels.T]\ninput = "D/ai3"\nquantity = "x"\nunit = "N"\n', "small letters"),
    ],
)
def test_a_channel_that_cannot_be_recorded_is_named(text: str, says: str) -> None:
    with pytest.raises(BadInputError, match=says):
        parse_rig(f'{text}[load_cell]\ncalibration = "x.toml"\n', "rig.toml")
