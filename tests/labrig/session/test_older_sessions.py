"""Sessions of the layout's versions 1 to 3, as an earlier labrig wrote them, are still of use."""

from __future__ import annotations

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

from labrig.experiment.resume import Resumption
from labrig.report.tables.overview import overview
from labrig.session import (
    SessionWriter,
    compare_sessions,
    open_session,
    recover,
    store_measurements,
    verify,
)
from labrig.session.format import layout
from labrig.session.recording.journal import journal_path
from protocols.execution import events as ev
from protocols.execution.events import Outcome
from tests.cases import few
from tests.labrig.session.measured import measurements
from tests.labrig.session.session_recording import CHANNELS, FRAME_SHAPE, RATE_HZ, TEXTS

DATA = Path(__file__).parent / "data"
CUT = 5000  # bytes that the disk never got


OLDER = (1, 2, 3)


@pytest.fixture
def old(tmp_path, request):
    version = getattr(request, "param", 1)
    return Path(shutil.copy(DATA / f"version_{version}.hdf5", tmp_path / "old.h5"))


EACH = [(v, v) for v in OLDER]
of_each = pytest.mark.parametrize(("old", "version"), EACH, indirect=["old"])
of_the_oldest = pytest.mark.parametrize(("old", "version"), few(EACH), indirect=["old"])


@pytest.mark.slow
@of_each
def test_an_older_session_passes_verify_and_a_changed_sample_is_found(old, version):
    assert all(check.ok for check in verify(old))
    with h5py.File(old, "r+") as file:
        file["session/run_001/signals/force"][7] += 1e-9
    assert [check.name for check in verify(old) if not check.ok] == ["checksums"]


@pytest.mark.slow
@of_each
def test_measurements_are_kept_in_an_older_session_without_changing_its_recording(old, version):
    with open_session(old) as session:
        before = session.checksum
    store_measurements(old, measurements())
    with open_session(old) as session:
        assert (session.version, session.checksum) == (version, before)
    assert all(check.ok for check in verify(old))


def test_a_session_of_version_2_has_no_devices_and_its_marks(tmp_path):
    with open_session(DATA / "version_2.hdf5") as session:
        assert session.version == 2
        assert session.devices == ()
        assert [c.unit for c in session.signals] == ["N", "A", "V"]
        assert list(session.runs[1].readings["why"][:3]) == ["", "a bubble", ""]


def test_a_session_of_version_1_is_read_with_the_units_of_its_channels(old):
    with open_session(old) as session:
        assert session.version == 1
        assert [(c.name, c.unit) for c in session.signals] == [
            ("force", "N"), ("current", "A"), ("drive", "V"),
        ]  # fmt: skip
        assert session.ranges_V == (0.05, 0.5, 5.0)
        run = session.runs[0]
        values = run.values(run.readings[1])
        assert values["drive_V"] == 2.0
        assert values["current_A"] == 0.02
        assert values["force_N"] == run.readings["force_N"][1] == pytest.approx(3.5e-3, abs=2e-4)
        assert [c.most for c in overview(session).channels][2] == 2.0
    assert all(check.ok for check in verify(old))


@pytest.mark.slow
@of_the_oldest
def test_an_older_session_is_recovered_from_its_journal_in_its_own_version(old, version, tmp_path):
    crashed = tmp_path / "crashed.h5"
    journal = (DATA / f"version_{version}.hdf5-journal").read_bytes()
    journal_path(crashed).write_bytes(journal[:-CUT])
    report = recover(crashed, tmp_path / "whole.h5")
    assert report.from_journal
    assert report.outcome is Outcome.CRASHED
    with h5py.File(tmp_path / "whole.h5") as file:
        assert file.attrs["labrig_format"] == version
    with open_session(tmp_path / "whole.h5") as new, open_session(old) as whole:
        assert new.runs[0].completed
        np.testing.assert_array_equal(new.runs[0].readings, whole.runs[0].readings)
        count = len(new.runs[1].readings)
        assert 0 < count <= len(whole.runs[1].readings)
    assert all(check.ok for check in verify(tmp_path / "whole.h5"))
    assert any("session/outcome" in text for text in compare_sessions(tmp_path / "whole.h5", old))


@pytest.mark.slow
@of_the_oldest
def test_the_runs_of_an_older_session_are_copied_into_a_new_one_when_it_is_resumed(
    old, version, tmp_path
):
    with open_session(old) as session:
        writer = SessionWriter(
            tmp_path / "new.h5",
            schedule=session.schedule,
            texts=TEXTS,
            resolved={},
            channels=CHANNELS,
            rate_hz=RATE_HZ,
            frame_shape=FRAME_SHAPE,
        )
        with writer:
            Resumption(session).publish(writer.handle, 500.0)
            stopped = ev.SessionStopped(
                900.0, outcome=Outcome.COMPLETED, reason="done", output=ev.OutputState.SAFE, wall=""
            )
            writer.handle(stopped)
        with open_session(tmp_path / "new.h5") as new:
            assert new.version == layout.FORMAT
            for before, after in zip(session.runs, new.runs, strict=True):
                for row, copy in zip(before.readings, after.readings, strict=True):
                    assert after.values(copy) == before.values(row)
                np.testing.assert_array_equal(before.signal_V("force"), after.signal_V("force"))
