"""A session records what happened: on which devices, and what nobody was asked."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from labrig.report.tables.overview import overview
from labrig.session import open_session
from tests.end_to_end.real_rig import SHORT, serving
from tests.end_to_end.small_rig import ONE_POSITION, labrig, make_rig, run_rig

pytestmark = pytest.mark.slow
PROTOCOL = ONE_POSITION + 'mode = "paper"\n'
AMPLIFIER = 'gain = 10.0\nproduct = "Kepco BOP 20"\nserial = "E123"\ncalibrated = 2026-03-04'


@pytest.fixture(scope="module")
def virtual(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = make_rig(tmp_path_factory.mktemp("virtual"), PROTOCOL)
    rig = folder / "rig.toml"
    rig.write_text(rig.read_text().replace("gain = 10.0", AMPLIFIER))
    return run_rig(folder)


def test_a_simulated_rig_names_every_part_as_simulated(virtual: Path) -> None:
    with open_session(virtual) as session:
        assert session.boards == "simulated"
        parts = {device.part: device for device in session.devices}
        assert set(parts) == {"boards", "camera", "stage", "load_cell", "amplifier"}
        assert all(device.identity.is_simulated for device in session.devices)
    assert parts["boards"].identity.driver.startswith("NI-DAQmx")
    amplifier, cell = parts["amplifier"], parts["load_cell"]
    assert (amplifier.identity.product, amplifier.identity.serial) == ("Kepco BOP 20", "E123")
    assert amplifier.calibration.date == "2026-03-04"
    assert cell.calibration.name == "load_cell.toml"
    assert len(cell.calibration.sha256) == 64
    assert parts["camera"].calibration.name == "optics.json"
    assert parts["camera"].identity.driver == ""  # OpenCV has no part in it


def test_a_replay_has_the_devices_of_what_it_plays_and_says_what_that_is(
    virtual: Path, tmp_path: Path
) -> None:
    assert labrig("replay", virtual, "-o", tmp_path / "again.h5") == 0
    with open_session(virtual) as original, open_session(tmp_path / "again.h5") as again:
        assert again.devices == original.devices
        assert again.replay_of == original.identifier
        assert original.replay_of == ""
        assert dict(overview(again).facts)["replay of"] == original.identifier


@pytest.fixture(scope="module")
def over_sockets(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`labrig run --yes` on a simulated rig in another process, in real time."""
    if sys.platform == "win32":
        pytest.skip("the simulated stage needs a pty")
    with serving(tmp_path_factory.mktemp("served")) as rig:
        rig.be_short(SHORT.replace("moisten = false", "moisten = true"))
        return rig.completed()


@pytest.mark.thorough
def test_a_simulated_rig_over_sockets_is_recorded_as_simulated(over_sockets: Path) -> None:
    with open_session(over_sockets) as session:
        assert session.simulated
        assert session.boards == "simulated"
        facts = dict(overview(session).facts)
        found = {device.part: device.identity for device in session.devices}
    assert facts["boards"] == "simulated"
    assert (found["camera"].product, found["camera"].is_simulated) == (
        "labrig simulated camera", True,
    )  # fmt: skip
    # the protocols of the others have no place to say so
    assert (found["stage"].serial, found["stage"].is_simulated) == ("60001", None)


def test_with_yes_nobody_is_recorded_as_having_moistened_the_sheet(over_sockets: Path) -> None:
    with open_session(over_sockets) as session:
        log = [(event.kind, event.subject) for event in session.events]
        assert ("not asked", "moisten") in log
        assert not {"asked", "answered"} & {kind for kind, _ in log}
        assert session.runs[0].since_wetting_s is None


@pytest.mark.thorough
def test_the_analysis_says_that_the_time_since_wetting_is_not_known(
    over_sockets: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert labrig("analyze", over_sockets) == 0
    assert "When the sheet was moistened is not known" in capsys.readouterr().err
    assert labrig("export", over_sockets, "-o", tmp_path / "tables") == 0
    header, *rows = (tmp_path / "tables" / "forces.csv").read_text().splitlines()
    at = header.split(",").index("wetted_s") if "wetted_s" in header.split(",") else None
    assert rows
    assert at is None or {row.split(",")[at] for row in rows} == {""}


def test_a_simulated_operator_does_moisten_the_sheet(virtual: Path) -> None:
    with open_session(virtual) as session:
        assert session.runs[0].since_wetting_s is not None
        assert ("answered", "moisten") in {(e.kind, e.subject) for e in session.events}
