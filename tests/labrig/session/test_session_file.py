"""The session file: what goes in comes out, number by number."""

from __future__ import annotations

import subprocess
import sys

import h5py
import numpy as np
import pytest

from labrig.errors import BadInputError
from labrig.session import SessionWriter, open_session, verify
from labrig.session.recording import writer
from labrig.session.recording.create import create_file
from labrig.session.recording.journal import journal_path
from labrig.session.recording.locking import lock
from protocols.execution import events as ev
from tests.labrig.session.session_recording import (
    FRAME_SHAPE,
    LATE_S,
    NAMES,
    OFFSET_V,
    SENSITIVITY_V_PER_N,
    TEXTS,
    drive_V,
    force_N,
    record,
    session_events,
    settings,
    small_schedule,
)
from tests.processes import last_words


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("recorded") / "session.h5"
    record(path, small_schedule())
    return path


@pytest.mark.slow
def test_what_was_planned_is_in_the_file(recorded):
    with open_session(recorded) as session:
        assert session.schedule == small_schedule()
        assert session.texts == TEXTS
        assert session.resolved == {"current_sense": {"shunt_ohm": 2.0}}
        assert session.versions["numpy"] == np.__version__
        assert session.simulated
        assert session.channels == NAMES


@pytest.mark.slow
def test_the_outcome_and_its_reason_are_in_the_file(recorded):
    with open_session(recorded) as session:
        assert session.outcome is ev.Outcome.COMPLETED
        assert session.reason == "All runs were done."
        assert session.output_state is ev.OutputState.SAFE
        assert session.started == "2026-11-21T09:00:00+00:00"


def test_raw_signals_come_back_to_the_last_bit(recorded):
    blocks = [e for e in session_events(small_schedule()) if isinstance(e, ev.SignalsArrived)]
    with open_session(recorded) as session:
        for run in session.runs:
            sent = np.hstack([e.block.volts for e in blocks if e.run == run.planned.index])
            for row, name in zip(sent, NAMES, strict=True):
                np.testing.assert_array_equal(run.signal_V(name), row)
            assert run.samples == sent.shape[1]


def test_signals_stand_on_the_time_of_the_run(recorded):
    with open_session(recorded) as session:
        run = session.runs[1]
        np.testing.assert_array_equal(run.signal_V("drive"), drive_V(run.planned, run.time_s))
        force = (run.signal_V("force") - OFFSET_V) / SENSITIVITY_V_PER_N
        np.testing.assert_allclose(force, force_N(run.planned, run.time_s), atol=1e-4)


def test_readings_and_their_frames_come_back(recorded):
    taken = [e for e in session_events(small_schedule()) if isinstance(e, ev.ReadingTaken)]
    with open_session(recorded) as session:
        for event in taken:
            run = session.runs[event.run]
            row = run.readings[event.planned.index]
            assert row["kind"] == event.planned.kind
            assert row["force_N"] == event.values["force_N"]
            assert row["sample_index"] == event.sample_index
            assert row["time_s"] == pytest.approx(row["planned_s"] + LATE_S, abs=1e-9)
            np.testing.assert_array_equal(run.frame(event.planned.index), event.frame.image)
            assert run.frame_offset_s(event.planned.index) == 4e-3
        assert run.image(0).shape == FRAME_SHAPE


def test_writes_carry_their_lateness_and_sample_index(recorded):
    with open_session(recorded) as session:
        writes = session.runs[0].writes
        np.testing.assert_allclose(writes["lateness_s"], LATE_S, atol=1e-9)
        planned = [step.time_s for step in session.runs[0].planned.steps]
        np.testing.assert_array_equal(writes["planned_s"], planned)
        np.testing.assert_allclose(
            writes["sample_index"], np.array(planned) * 1e3 + 201.4, atol=1e-6
        )


def test_the_log_has_one_line_for_each_event_in_order(recorded):
    quiet = (ev.SignalsArrived, ev.ReadingTaken, ev.VoltageSet, ev.FramesArrived)
    sent = [e for e in session_events(small_schedule()) if not isinstance(e, quiet)]
    with open_session(recorded) as session:
        assert [line.time_s for line in session.events] == [event.time_s for event in sent]
        assert session.events[1].subject == "move"


@pytest.mark.thorough
@pytest.mark.slow
def test_a_long_warning_is_not_cut(tmp_path):
    schedule = small_schedule()
    text = "Grüße " * 200
    with SessionWriter(tmp_path / "s.h5", **settings(schedule)) as writer:
        for event in session_events(schedule):
            writer.handle(event)
            if isinstance(event, ev.SessionStarted):
                writer.handle(ev.Warned(100.0, text))
    with open_session(tmp_path / "s.h5") as session:
        assert [line.text for line in session.events if line.kind == "warned"] == [text]


@pytest.mark.slow
def test_a_mark_makes_a_reading_invalid_and_the_raw_row_stays(tmp_path):
    schedule = small_schedule()
    with SessionWriter(tmp_path / "s.h5", **settings(schedule)) as writer:
        for event in session_events(schedule):
            writer.handle(event)
            if isinstance(event, ev.RunStopped) and event.run == 1:
                writer.handle(
                    ev.ReadingMarked(
                        event.time_s, run=1, reading=3, why="stuck in the rolls", who="anna"
                    )
                )
                writer.handle(
                    ev.ReadingMarked(event.time_s, run=0, reading=None, why="dry", who="anna")
                )
    with open_session(tmp_path / "s.h5") as session:
        readings = session.runs[1].readings
        assert list(np.flatnonzero(~readings["valid"])) == [3]
        assert readings["why"][3] == "stuck in the rolls"
        assert not session.runs[0].readings["valid"].any()
    with h5py.File(tmp_path / "s.h5") as file:
        assert file["session/run_001/readings"]["valid"].all()


@pytest.mark.thorough
@pytest.mark.slow
def test_samples_that_were_lost_leave_a_gap_of_nan(tmp_path):
    schedule = small_schedule()
    with SessionWriter(tmp_path / "s.h5", **settings(schedule)) as writer:
        for event in session_events(schedule):
            lost = isinstance(event, ev.SignalsArrived) and event.block.first_index == 100
            if not lost:
                writer.handle(event)
    with open_session(tmp_path / "s.h5") as session:
        force = session.runs[0].signal_V("force")
        assert list(np.flatnonzero(np.isnan(force))) == list(range(100, 150))
        assert np.isfinite(session.runs[0].time_s).all()


@pytest.mark.thorough
@pytest.mark.slow
def test_a_session_without_a_camera_has_no_frames(tmp_path):
    record(tmp_path / "s.h5", small_schedule(), frame_shape=None)
    with open_session(tmp_path / "s.h5") as session:
        assert session.runs[0].frame_count == 0
        assert session.runs[0].frame(0) is None
        assert session.frame_shape is None


def test_any_viewer_finds_its_way_by_nexus_defaults(recorded):
    with h5py.File(recorded) as file:
        entry = file[file.attrs["default"]]
        data = entry[entry.attrs["default"]]
        assert data.attrs["NX_class"] == "NXdata"
        signal, axis = data[data.attrs["signal"]], data[data.attrs["axes"][0]]
        assert signal.shape == axis.shape == (24,)
        assert signal.attrs["units"] == "N"
        run = file["session/run_000"]
        signals = run[run.attrs["default"]]
        assert signals[signals.attrs["signal"]].attrs["units"] == "V"


def test_no_dataset_has_a_variable_length(recorded):
    def visit(name, item):
        assert isinstance(item, h5py.Group) or not item.dtype.hasobject, name

    with h5py.File(recorded) as file:
        file.visititems(visit)


def test_nothing_is_left_beside_a_session_that_was_closed(recorded):
    assert [entry.name for entry in recorded.parent.iterdir()] == ["session.h5"]


def test_a_session_that_was_closed_is_not_called_damaged(recorded):
    with open_session(recorded) as session:
        run = session.runs[0]
    for read in (session.to_dataframe, lambda: run.image(0), lambda: run.readings):
        with pytest.raises(BadInputError, match=r"session\.h5: this session was closed; open it"):
            read()


def test_an_existing_file_is_never_overwritten(recorded):
    before = recorded.read_bytes()
    with pytest.raises(BadInputError, match=r"exists already; choose another name\.$"):
        SessionWriter(recorded, **settings(small_schedule()))
    assert recorded.read_bytes() == before


def test_a_session_that_another_one_is_making_at_its_place_is_told_from_one_that_crashed(tmp_path):
    beside = journal_path(tmp_path / "s.h5")
    with beside.open("wb") as file:
        assert lock(file)
        with pytest.raises(BadInputError, match=r"another labrig is making a session at .*s\.h5;"):
            SessionWriter(tmp_path / "s.h5", **settings(small_schedule()))
    with pytest.raises(BadInputError, match="left from an earlier session; run labrig recover"):
        SessionWriter(tmp_path / "s.h5", **settings(small_schedule()))


def test_a_folder_that_is_not_there_is_named(tmp_path):
    with pytest.raises(BadInputError, match=r"no/s\.h5 cannot be written"):
        SessionWriter(tmp_path / "no" / "s.h5", **settings(small_schedule()))


HOLD = """
import sys, h5py
with h5py.File(sys.argv[1], "r"):
    print("open", flush=True)
    sys.stdin.read()
"""


@pytest.mark.thorough
@pytest.mark.slow
def test_a_viewer_that_has_the_new_file_open_does_not_end_the_recording(tmp_path, monkeypatch):
    path = tmp_path / "looked_at.h5"
    viewers = []

    def made_and_looked_at(beside, setup):
        create_file(beside, setup)
        viewer = subprocess.Popen(
            [sys.executable, "-c", HOLD, beside], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        viewers.append(viewer)
        assert viewer.stdout.readline() == b"open\n"

    monkeypatch.setattr(writer, "create_file", made_and_looked_at)
    try:
        record(path, small_schedule())
    finally:
        for viewer in viewers:
            last_words(viewer)
    assert all(check.ok for check in verify(path))


BEGIN = """
import sys, time, h5py
from pathlib import Path
from labrig.session.format.layout import LIBVER
from labrig.session.recording.locking import lock
with open(sys.argv[2], "w+b") as journal, h5py.File(sys.argv[1], "r+", libver=LIBVER) as file:
    assert lock(journal)
    print("open", flush=True)
    time.sleep(0.5)
    file.swmr_mode = True
    sys.stdin.read()
"""


@pytest.mark.thorough
@pytest.mark.slow
def test_a_session_that_is_just_beginning_can_be_looked_at(tmp_path):
    """The file cannot be read between its opening for writing and its switch to shared reading."""
    path = tmp_path / "beginning.h5"
    record(path, small_schedule())
    begins = subprocess.Popen(
        [sys.executable, "-c", BEGIN, path, journal_path(path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    try:
        assert begins.stdout.readline() == b"open\n"
        with open_session(path, live=True) as session:
            assert session.runs
    finally:
        last_words(begins)
