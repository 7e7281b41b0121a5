"""Derived measurements live in the session, can be dropped, and never touch what was recorded."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from labrig.errors import BadInputError, LabrigError
from labrig.session import (
    compare_sessions,
    drop_measurements,
    load_measurements,
    open_session,
    store_measurements,
    verify,
)
from labrig.session.derived.arrays import measurements_from_tables, tables_from_measurements
from model.measurements import Measurements, Reading
from tests.labrig.report_data import measure
from tests.labrig.session.measured import measurements, same
from tests.labrig.session.session_recording import record, small_schedule

PAGE = Path(__file__).parents[3] / "docs" / "reference" / "session.md"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("recorded") / "session.h5"
    record(path, small_schedule())
    return path


@pytest.fixture
def session(recorded, tmp_path):
    return shutil.copy(recorded, tmp_path / "s.h5")


@pytest.mark.slow
def test_measurements_come_back_to_the_last_bit(session):
    store_measurements(session, measurements())
    assert same(load_measurements(session), measurements())


@pytest.mark.thorough
def test_nothing_measured_comes_back_too(session):
    store_measurements(session, Measurements(sheets={}, conditions=()))
    assert same(load_measurements(session), Measurements(sheets={}, conditions=()))


@pytest.mark.slow
def test_measurements_changed_by_hand_are_read_with_a_warning(session):
    store_measurements(session, measurements())
    assert not any("another program" in one for one in load_measurements(session).warnings)
    with h5py.File(session, "r+") as file:
        file["/session/derived/points"][0] = file["/session/derived/points"][1]
    assert any("another program" in one for one in load_measurements(session).warnings)


@pytest.mark.slow
def test_raw_data_are_the_same_before_and_after(session, recorded):
    store_measurements(session, measurements())
    assert all(check.ok for check in verify(session))
    with open_session(session) as with_them, open_session(recorded) as without:
        assert with_them.has_measurements
        assert with_them.checksum == without.checksum
    drop_measurements(session)
    assert compare_sessions(session, recorded) == []


@pytest.mark.thorough
@pytest.mark.slow
def test_measurements_made_again_replace_the_old_and_the_file_does_not_grow(session):
    store_measurements(session, measurements())
    size = session.stat().st_size
    store_measurements(session, measurements())
    assert session.stat().st_size <= size
    drop_measurements(session)
    with pytest.raises(BadInputError, match="labrig analyze"):
        load_measurements(session)


def test_a_crash_while_storing_leaves_the_session_as_it_was(session, monkeypatch):
    before = session.read_bytes()

    def crash(*_args, **_named):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("labrig.session.derived.store.set_attributes", crash)
    with pytest.raises(LabrigError, match="the disk is full"):
        store_measurements(session, measurements())
    assert session.read_bytes() == before
    assert list(session.parent.iterdir()) == [session]


@pytest.mark.slow
def test_measurements_that_were_changed_afterwards_are_noticed(session):
    store_measurements(session, measurements())
    with h5py.File(session, "r+") as file:
        table = file["session/derived/readings"]
        rows = table[()]
        rows["force_N"][0] *= 2
        table[...] = rows
    assert [check.name for check in verify(session) if not check.ok] == ["derived measurements"]


def test_tables_that_contradict_each_other_are_refused(session):
    store_measurements(session, measurements())
    with h5py.File(session, "r+") as file:
        rows = file["session/derived/curves"][()]
        rows["count"] = 10**9
        file["session/derived/curves"][...] = rows
    with pytest.raises(BadInputError, match="cannot be read"):
        load_measurements(session)


def test_tables_are_made_of_fixed_length_types_only():
    tables = tables_from_measurements(measurements())
    assert not any(table.dtype.hasobject for table in tables.values())
    assert same(measurements_from_tables(tables), measurements())


def test_series_kept_before_runs_were_counted_are_of_the_first_run():
    tables = tables_from_measurements(measurements())
    series = tables["series"]
    earlier = series[[name for name in series.dtype.names if name != "run"]]
    found = measurements_from_tables({**tables, "series": earlier}).series
    assert [one.run for one in found] == [0] * len(series)


@pytest.mark.slow
def test_what_the_page_shows_reads_the_curves_without_labrig(session, monkeypatch):
    pytest.importorskip("pandas")
    (example,) = re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert "labrig" not in example
    store_measurements(session, measurements())
    monkeypatch.chdir(session.parent)
    session.rename("session.h5")
    found: dict[str, object] = {}
    exec(compile(example, str(PAGE), "exec"), found)
    assert list(found["readings"])[:1] != []
    (wanted, *_) = (c for c in measurements().conditions if c.curve is not None)
    np.testing.assert_array_equal(found["curve"]["x_m"], wanted.curve.x_m)
    assert found["place"]["voltage_V"] == wanted.voltage_V


@pytest.mark.slow
def test_the_means_that_the_page_shows_are_those_of_labrig(session, monkeypatch):
    """Each sheet by itself, and without the first pulses: /session/data has all readings."""
    pytest.importorskip("pandas")
    (example,) = re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    measured = measure("long", "short")
    first = measured.conditions[0]
    pulse = Reading(index=99, kind="discarded", force_N=1.0)
    wrong = Reading(index=98, kind="kept", force_N=1.0, valid=False, why="knocked")
    changed = replace(first, readings=(pulse, wrong, *first.readings))
    store_measurements(session, replace(measured, conditions=(changed, *measured.conditions[1:])))
    monkeypatch.chdir(session.parent)
    session.rename("session.h5")
    found: dict[str, Any] = {}
    exec(compile(example, str(PAGE), "exec"), found)
    assert len(found["means"]) == len(measured.conditions)
    for one in measured.conditions:
        place = (one.configuration.encode(), one.position_m, one.voltage_V, 0, 0)
        row, forces_N = found["means"].loc[place], one.forces_N()
        assert row["mean"] == pytest.approx(forces_N.mean())
        assert row["sem"] == pytest.approx(forces_N.std(ddof=1) / len(forces_N) ** 0.5)


def test_each_column_of_what_was_derived_has_its_unit(session):
    store_measurements(session, measurements())
    with h5py.File(session) as file:
        derived = file["session/derived"]
        units = {
            name: dict(
                zip(
                    derived[name].attrs.get("columns", derived[name].dtype.names or ()),
                    derived[name].attrs["column_units"],
                    strict=True,
                )
            )
            for name in derived
            if derived[name].shape
        }
    assert units["points"]["curvature_per_m"] == "1/m"
    assert units["samples"]["force_N"] == "N"
    assert units["curves"]["has_curvature_per_m"] == ""
    assert units["readings"]["session_s"] == "s"
