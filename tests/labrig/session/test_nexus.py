"""The libraries behind NeXpy, silx, h5web and NOMAD read a fresh session."""

from __future__ import annotations

import subprocess
import sys
import sysconfig
from pathlib import Path

import h5py
import numpy as np
import pytest

from labrig.session import open_session, recover, verify
from labrig.session.format import layout
from labrig.session.recording.journal import Journal
from tests.labrig.session.session_recording import record, small_schedule


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    path = tmp_path_factory.mktemp("nexus") / "s.h5"
    record(path, small_schedule())
    return path


def script(name):
    return Path(sysconfig.get_path("scripts")) / name


@pytest.mark.slow
def test_nexusformat_reads_every_group_and_finds_the_data(session):
    from nexusformat.nexus import NXdata, nxload

    root = nxload(str(session))
    assert "run_001:NXsubentry" in root.tree
    data = root.get_default()
    assert isinstance(data, NXdata)
    assert data.nxsignal.nxname == "force_N"
    assert data.nxsignal.nxdata.shape == data.nxaxes[0].nxdata.shape == (24,)


@pytest.mark.slow
def test_nxvalidate_finds_no_error(session):
    found = subprocess.run(
        [sys.executable, script("nxvalidate"), "-e", session],
        capture_output=True,
        text=True,
        check=True,
    )
    assert "Application Definition: NXsensor_scan" in found.stdout
    assert "Total number of errors: 0" in found.stdout


@pytest.mark.thorough
def test_sensors_measure_in_the_words_of_nexus_where_it_has_one(session):
    with h5py.File(session) as file:
        sensors = file["session/instrument/environment"]
        said = {
            n: sensors[f"{n}/measurement"].asstr()[()]
            for n in sensors
            if n.endswith(("A", "V", "N"))
        }
    assert said == {"force_N": "force", "current_A": "current", "drive_V": "voltage"}


@pytest.mark.thorough
def test_pynxtools_sees_the_entry_and_what_it_declares(session):
    found = subprocess.run(
        [sys.executable, script("validate_nexus"), session],
        capture_output=True,
        text=True,
        check=True,
    )
    said = found.stdout + found.stderr
    assert "according to the `NXsensor_scan` application definition" in said
    assert "required" not in said  # nothing that the definition requires is missing


@pytest.mark.slow
def test_silx_plots_the_force_of_all_readings(session):
    import silx.io
    from silx.io import nxdata

    with silx.io.open(str(session)) as file:
        found = nxdata.get_default(file)
        assert found.is_valid
        assert found.signal_dataset_name == "force_N"
        assert found.axes_dataset_names == ["time_s"]
        assert np.isfinite(np.asarray(found.signal)).all()


@pytest.mark.slow
def test_h5grove_serves_what_h5web_shows(session):
    from h5grove.content import DatasetContent, get_content_from_file

    with h5py.File(session) as file:
        names = [name for name in file["session"] if name != "additional"]
    for name in ("data/force_N", "data/time_s", "run_000/readings", "run_000/acquisition", *names):
        with get_content_from_file(session, f"/session/{name}", lambda code, why: None) as content:
            assert content.metadata()["name"]
            content.attributes()
            if isinstance(content, DatasetContent):
                content.data()


def test_readings_of_all_runs_are_those_of_the_runs(session):
    with open_session(session) as opened, h5py.File(session) as file:
        data = file["session/data"]
        rows = np.concatenate([run.readings_as_taken for run in opened.runs])
        np.testing.assert_array_equal(data["force_N"][()], rows["force_N"])
        np.testing.assert_array_equal(data["voltage_V"][()], rows["voltage_V"])
        np.testing.assert_array_equal(data["valid"][()], rows["valid"])
        assert (np.diff(data["time_s"][()]) > 0).all()
        positions = {run.planned.index: run.planned.position_m for run in opened.runs}
        at = [np.nan if positions[run] is None else positions[run] for run in data["run"][()]]
        np.testing.assert_array_equal(data["position_m"][()], at)


def test_every_column_states_its_unit(session):
    with h5py.File(session) as file:
        readings = file["session/run_000/readings"]
        units = dict(zip(readings.dtype.names, readings.attrs["column_units"], strict=True))
        assert units["force_N"] == "N"
        assert units["time_s"] == "s"
        assert units["kind"] == ""
        assert file["session/events"].attrs["column_units"][0] == "s"


def test_columns_say_from_where_they_count_and_that_marks_may_follow(session):
    from_0 = "counted from 0; labrig show and labrig mark count from 1"
    with h5py.File(session) as file:
        for name in ("data/run", "data/reading", "run_000/frames/reading"):
            assert file[f"session/{name}"].attrs["comment"].startswith(from_0)
        for name in ("run_000/readings", "run_000/marks", "events"):
            assert from_0 in file[f"session/{name}"].attrs["comment"]
        for name in ("data/valid", "run_000/readings"):
            comment = file[f"session/{name}"].attrs["comment"]
            assert "as recorded; later marks are in /session/marks" in comment


@pytest.mark.thorough
@pytest.mark.slow
def test_anybody_may_add_anything_to_the_additional_group(session, tmp_path):
    path = tmp_path / "s.h5"
    path.write_bytes(session.read_bytes())
    with open_session(path) as opened:
        before = opened.checksum
    with h5py.File(path, "r+") as file:
        group = file[layout.ADDITIONAL]
        group["remark"] = "a text of any length"
        group["link"] = h5py.SoftLink("/session/data/force_N")
        group.create_group("mine/deep/er/than/any/other/group/of/a/session").attrs["x"] = ["a"]
    assert all(check.ok for check in verify(path))
    with open_session(path) as opened:
        assert opened.checksum == before


def test_a_link_to_anything_but_a_sensor_is_refused(session, tmp_path):
    path = tmp_path / "s.h5"
    path.write_bytes(session.read_bytes())
    with h5py.File(path, "r+") as file:
        del file["session/data/force_N"]
        file["session/data/force_N"] = h5py.SoftLink("/session/run_000/signals/force")
    assert "/session/data/force_N is a link" in verify(path)[0].found


@pytest.mark.slow
@pytest.mark.thorough
def test_readings_of_all_runs_come_back_from_the_journal(session, tmp_path, monkeypatch):
    monkeypatch.setattr(Journal, "remove", Journal.close)
    crashed = tmp_path / "crashed.h5"
    record(crashed, small_schedule())
    crashed.unlink()
    recover(crashed, tmp_path / "whole.h5")
    with h5py.File(tmp_path / "whole.h5") as whole, h5py.File(session) as file:
        for name in file["session/data"]:
            np.testing.assert_array_equal(
                whole[f"session/data/{name}"][()], file[f"session/data/{name}"][()]
            )
