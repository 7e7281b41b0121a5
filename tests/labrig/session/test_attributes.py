"""Attributes are part of what is recorded: checksums cover them, and recovery makes them again."""

from __future__ import annotations

import shutil

import h5py
import numpy as np
import pytest

from labrig.session import compare_sessions, open_session, recover, verify
from labrig.session.format import layout
from labrig.session.recording.journal import Journal, journal_path
from tests.cases import few
from tests.labrig.session.session_recording import record, small_schedule


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("recorded") / "session.h5"
    record(path, small_schedule(readings=1, positions_m=(0.005,)))
    return path


@pytest.fixture
def session(recorded, tmp_path):
    return shutil.copy(recorded, tmp_path / "s.h5")


def change(path, name, attribute, value):
    with h5py.File(path, "r+") as file:
        file[name].attrs[attribute] = value


def failed(path):
    return {check.name: check.found for check in verify(path) if not check.ok}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "attribute", "value"),
    few(
        [
            ("/session/run_000", "position_m", 0.006),
            ("/session/run_000", "configuration", np.bytes_(b"shor")),
            ("/session/run_001/signals/force", "units", np.bytes_(b"N")),
            ("/session/run_001/frames/time", "units", np.bytes_(b"m")),
            ("/session", "default", np.bytes_(b"run_001")),
            ("/session/run_000/readings", "remark", 1.0),
            ("/session/checksums", "remark", 1.0),
        ]
    ),
)
def test_an_attribute_that_was_changed_or_added_is_found(session, name, attribute, value):
    change(session, name, attribute, value)
    assert name in " ".join(failed(session).values())


@pytest.mark.slow
def test_an_attribute_that_was_removed_is_found(session):
    with h5py.File(session, "r+") as file:
        del file["session/run_000"].attrs["position_m"]
    assert "changed: /session/run_000" in failed(session)["checksums"]


@pytest.mark.slow
def test_an_attribute_without_a_fixed_length_is_found(session):
    change(session, "/session/run_000", "purpose", "free shape")
    assert "changed: /session/run_000" in failed(session)["checksums"]


@pytest.mark.slow
def test_a_group_that_was_added_is_found(session):
    with h5py.File(session, "r+") as file:
        file.create_group("session/run_000/more")
    assert failed(session)["datasets"] == "/session/run_000/more"


@pytest.mark.thorough
@pytest.mark.slow
def test_comparison_names_the_object_whose_attribute_differs(session, recorded):
    change(session, "/session/run_000", "position_m", 0.006)
    assert compare_sessions(session, recorded) == ["/session/run_000 differs: its attributes."]


@pytest.mark.slow
def test_attributes_come_back_from_the_journal(recorded, tmp_path, monkeypatch):
    crashed = tmp_path / "crashed.h5"
    monkeypatch.setattr(Journal, "remove", Journal.close)
    record(crashed, small_schedule(readings=1, positions_m=(0.005,)))
    crashed.unlink()
    assert journal_path(crashed).exists()
    recover(crashed, tmp_path / "whole.h5")
    assert failed(tmp_path / "whole.h5") == {}
    assert compare_sessions(tmp_path / "whole.h5", recorded) == []
    with h5py.File(tmp_path / "whole.h5") as file:
        assert file["session/run_000"].attrs["position_m"] == 0.005
        assert file["session/run_000/signals/force"].attrs["units"] == "V"


@pytest.mark.slow
def test_the_checksum_of_the_recording_covers_its_attributes(recorded, tmp_path):
    record(tmp_path / "b.h5", small_schedule(readings=1, positions_m=(0.006,)))
    with open_session(recorded) as a, open_session(tmp_path / "b.h5") as b:
        assert a.version == b.version == layout.FORMAT
        assert a.checksum != b.checksum
