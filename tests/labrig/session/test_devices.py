"""Which devices a session was recorded with, and whether they were simulated."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from drivers.interfaces import DeviceIdentity
from labrig.cli.main import run
from labrig.library.entry import read_entry
from labrig.report.tables.overview import overview
from labrig.session import open_session, recover
from labrig.session.format.devices import CalibrationRecord, RecordedDevice, boards_in_words
from labrig.session.recording.journal import Journal, journal_path
from tests.labrig.session.session_recording import record, small_schedule

DATA = Path(__file__).parent / "data"
SHORT = small_schedule(readings=1, positions_m=(0.005,))


def board(name, is_simulated):
    identity = DeviceIdentity(
        name=name,
        maker="National Instruments",
        product="PCI-6703",
        serial="0A1B2C3D",
        driver="NI-DAQmx 26.0",
        is_simulated=is_simulated,
    )
    return RecordedDevice(part="boards", kind="ni", identity=identity)


CELL = RecordedDevice(
    part="load_cell",
    identity=DeviceIdentity(serial="GSO-4711"),
    calibration=CalibrationRecord(name="load_cell.toml", date="2026-11-02", sha256="ab" * 32),
)


@pytest.mark.parametrize(
    ("states", "simulated", "said"),
    [
        ([True, True], True, "simulated"),
        ([False, False], False, "real"),
        ([True, False], True, "a simulated, b real"),
        ([False, None], False, "a real, b not known"),
        ([None, None], False, "not known"),
        ([], True, "simulated"),
        ([], False, "not known"),
    ],
)
def test_boards_are_told_as_they_are(states, simulated, said):
    devices = [board(name, state) for name, state in zip("ab", states, strict=False)]
    assert boards_in_words(devices, simulated=simulated) == said


@pytest.mark.slow
def test_devices_are_recorded_shown_and_survive_a_crash(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(Journal, "remove", Journal.close)
    devices = (board("PCI6703", False), board("PCI6034E", True), CELL)
    record(tmp_path / "s.h5", SHORT, devices=devices)
    (tmp_path / "s.h5").rename(tmp_path / "whole.h5")
    assert journal_path(tmp_path / "s.h5").exists()
    recover(tmp_path / "s.h5", tmp_path / "recovered.h5")
    for name in ("whole.h5", "recovered.h5"):
        with open_session(tmp_path / name) as session:
            assert session.devices == devices
            assert session.boards == "PCI6703 real, PCI6034E simulated"
            found = overview(session)
        assert dict(found.facts)["boards"] == "PCI6703 real, PCI6034E simulated"
        assert found.devices[2]["serial"] == "GSO-4711"
        assert found.devices[2]["calibration_sha256"] == "ab" * 32
    assert run(["show", str(tmp_path / "whole.h5")]) == 0
    printed = capsys.readouterr().out
    assert "0A1B2C3D" in printed
    assert "GSO-4711" in printed
    assert run(["show", str(tmp_path / "whole.h5"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["devices"][0]["driver"] == "NI-DAQmx 26.0"
    assert read_entry(tmp_path / "whole.h5", "whole.h5").boards.startswith("PCI6703 real")


@pytest.mark.thorough
@pytest.mark.slow
def test_of_a_session_without_devices_real_boards_are_not_claimed(tmp_path):
    record(tmp_path / "s.h5", SHORT, simulated=False)
    for path in (tmp_path / "s.h5", DATA / "version_2.hdf5"):
        with open_session(path) as session:
            assert session.boards == ("simulated" if session.simulated else "not known")
