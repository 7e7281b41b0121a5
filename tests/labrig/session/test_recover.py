"""What a kill, a power cut or a careless copy leaves is made whole again."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from labrig.errors import BadInputError
from labrig.session import SessionWriter, compare_sessions, open_session, recover, verify
from labrig.session.recording.journal import journal_path
from labrig.session.repair.recover import RecoverReport
from protocols.execution import events as ev
from tests.cases import few
from tests.labrig.session import session_recording
from tests.labrig.session.session_recording import record, session_events, settings, small_schedule
from tests.processes import ended


def until_reading(schedule, run, index):
    """The events up to a reading and including it."""
    for event in session_events(schedule):
        yield event
        if isinstance(event, ev.ReadingTaken) and (event.run, event.planned.index) == (run, index):
            return


@pytest.fixture(scope="module")
def cut_short(tmp_path_factory):
    """Session and journal as they stood after reading 3 of run 1, copied from under the writer."""
    folder = tmp_path_factory.mktemp("cut")
    schedule = small_schedule()
    path, copy = folder / "live.h5", folder / "cut.h5"
    writer = SessionWriter(path, **settings(schedule))
    for event in until_reading(schedule, 1, 3):
        writer.handle(event)
    wait_until_written(path, run=1, readings=4)
    shutil.copy(path, copy)
    shutil.copy(journal_path(path), journal_path(copy))
    writer.close()
    return copy


def wait_until_written(path, run, readings):
    """Until a second reader sees so many readings: the queue is empty and the file flushed."""
    waiting = session_recording.threading.Event()
    for _ in range(400):
        with open_session(path, live=True) as session:
            if len(session.runs[run].readings) == readings:
                return
        waiting.wait(0.02)
    raise AssertionError("the writer has not written what it was given")


@pytest.fixture
def cut(cut_short, tmp_path):
    path = tmp_path / "s.h5"
    shutil.copy(cut_short, path)
    shutil.copy(journal_path(cut_short), journal_path(path))
    return path


def readings_of(path):
    with open_session(path) as session:
        return [len(run.readings) for run in session.runs]


@pytest.mark.slow
def test_a_session_that_is_being_recorded_is_refused_with_what_to_do(cut):
    with pytest.raises(BadInputError, match=r"recorded right now, or .*labrig recover"):
        open_session(cut)


@pytest.mark.slow
def test_a_running_session_can_be_read_live(tmp_path):
    schedule = small_schedule()
    with SessionWriter(tmp_path / "s.h5", **settings(schedule)) as writer:
        for event in until_reading(schedule, 1, 3):
            writer.handle(event)
        wait_until_written(tmp_path / "s.h5", run=1, readings=4)
        with open_session(tmp_path / "s.h5", live=True) as session:
            assert session.outcome is ev.Outcome.RUNNING
            assert session.runs[0].completed
            assert session.runs[1].frame(3) is not None


@pytest.mark.slow
def test_a_session_left_by_a_crash_is_not_live(cut):
    with pytest.raises(BadInputError, match="labrig recover"):
        open_session(cut, live=True)


@pytest.mark.slow
def test_recovery_keeps_every_reading_and_says_crashed(cut):
    report = recover(cut)
    assert report.output == cut.with_name("s-recovered.h5")
    assert report.from_journal
    assert (report.runs_completed, report.readings) == (1, 8 + 4)
    with open_session(report.output) as session:
        assert session.outcome is ev.Outcome.CRASHED
        assert session.output_state is ev.OutputState.UNKNOWN
        assert "cut short" in session.reason
    assert all(check.ok for check in verify(report.output))


@pytest.mark.slow
def test_what_was_recovered_equals_what_a_whole_session_holds(cut, tmp_path):
    whole = tmp_path / "whole.h5"
    record(whole, small_schedule())
    report = recover(cut)
    with open_session(whole) as a, open_session(report.output) as b:
        np.testing.assert_array_equal(a.runs[0].readings, b.runs[0].readings)
        np.testing.assert_array_equal(a.runs[1].readings[:4], b.runs[1].readings)
        count = b.runs[1].samples
        for name in a.channels:
            np.testing.assert_array_equal(
                a.runs[1].signal_V(name)[:count], b.runs[1].signal_V(name)
            )
        np.testing.assert_array_equal(a.runs[1].frame(3), b.runs[1].frame(3))


@pytest.mark.slow
def test_who_opens_the_original_is_told_of_what_was_recovered(cut):
    """It told to run `labrig recover` again, which refused because the file was there."""
    recover(cut)
    with pytest.raises(BadInputError, match=r"what could be saved of it is in .*s-recovered\.h5\."):
        open_session(cut)
    os.utime(cut)  # as one that is recorded now under the same name
    with pytest.raises(BadInputError, match="recorded right now"):
        open_session(cut)


@pytest.mark.slow
def test_the_original_is_left_as_it_is(cut):
    before = cut.read_bytes(), journal_path(cut).read_bytes()
    recover(cut)
    assert (cut.read_bytes(), journal_path(cut).read_bytes()) == before


@pytest.mark.slow
def test_in_place_the_session_takes_its_own_name_and_the_journal_goes(cut):
    report = recover(cut, in_place=True)
    assert report.output == cut
    assert [entry.name for entry in cut.parent.iterdir()] == ["s.h5"]
    assert readings_of(cut) == [8, 4, 0]


@pytest.mark.slow
def test_without_its_journal_the_file_itself_is_enough(cut):
    journal_path(cut).unlink()
    report = recover(cut)
    assert not report.from_journal
    assert report.readings == 8 + 4
    assert report.outcome is ev.Outcome.CRASHED


@pytest.mark.slow
@pytest.mark.parametrize("damage", few(["gone", "empty", "cut in half", "overwritten"]))
def test_without_the_file_its_journal_is_enough(cut, damage):
    raw = cut.read_bytes()
    if damage == "gone":
        cut.unlink()
    else:
        left = {"empty": b"", "cut in half": raw[: len(raw) // 2]}
        cut.write_bytes(left.get(damage, b"\0" * len(raw)))
    report = recover(cut)
    assert report.readings == 8 + 4
    assert all(check.ok for check in verify(report.output))


@pytest.mark.thorough
@pytest.mark.slow
def test_rows_that_only_the_file_still_holds_are_added_to_those_of_the_journal(cut):
    raw = journal_path(cut).read_bytes()
    journal_path(cut).write_bytes(raw[: len(raw) * 2 // 3])
    report = recover(cut)
    assert report.readings == 8 + 4
    assert any("no whole record" in note for note in report.notes)


def test_with_neither_file_nor_journal_the_error_says_so(cut):
    journal_path(cut).write_bytes(b"not a journal")
    cut.write_bytes(cut.read_bytes()[:3000])
    with pytest.raises(BadInputError, match="nothing to recover"):
        recover(cut)


@pytest.mark.slow
def test_a_session_that_is_still_alive_is_not_recovered(tmp_path):
    with (
        SessionWriter(tmp_path / "s.h5", **settings(small_schedule())),
        pytest.raises(BadInputError, match="being recorded right now"),
    ):
        recover(tmp_path / "s.h5")


@pytest.mark.thorough
@pytest.mark.slow
def test_a_whole_session_needs_no_recovery(tmp_path):
    record(tmp_path / "s.h5", small_schedule())
    report = recover(tmp_path / "s.h5")
    assert report.output is None
    assert report.outcome is ev.Outcome.COMPLETED
    assert "was closed" in report.text  # recovery does not read all data: they may be damaged
    assert list(tmp_path.iterdir()) == [tmp_path / "s.h5"]


def test_recovery_overwrites_nothing(cut):
    cut.with_name("s-recovered.h5").write_text("mine")
    with pytest.raises(BadInputError, match="exists already"):
        recover(cut)


@pytest.mark.thorough
@pytest.mark.slow
def test_a_journal_of_the_whole_session_makes_the_same_file(tmp_path):
    """A kill between the last event and the removal of the journal loses nothing."""
    schedule, path = small_schedule(), tmp_path / "s.h5"
    kept = tmp_path / "kept.journal"
    writer = SessionWriter(path, **settings(schedule))
    kept.hardlink_to(journal_path(path))
    for event in session_events(schedule):
        writer.handle(event)
    writer.close()
    shutil.copy(path, tmp_path / "other.h5")
    with h5py.File(tmp_path / "other.h5", "r+") as file:
        del file["session/run_001"]
        file["session/outcome"][()] = b"running"
    shutil.copy(kept, journal_path(tmp_path / "other.h5"))
    report = recover(tmp_path / "other.h5")
    assert report.outcome is ev.Outcome.COMPLETED
    assert compare_sessions(path, report.output) == []


# ------------------------------------------------------------------------------------ power cuts


@pytest.mark.slow
@pytest.mark.parametrize("seed", [7, pytest.param(8, marks=pytest.mark.thorough)])
def test_after_a_power_cut_at_any_moment_every_synced_reading_is_there(tmp_path, monkeypatch, seed):
    """The disk keeps all that was synced, and any part of the rest."""
    from labrig.session.recording import journal as module
    from labrig.session.recording.rows import EventRows

    schedule = small_schedule(readings=1, positions_m=(0.0,))
    log: list[tuple[str, object]] = []
    plain_write, plain_sync = module.Journal.append, module.Journal.sync

    def append(self, rows: EventRows) -> None:
        begin = self._file.tell()
        plain_write(self, rows)
        log.append(("write", (begin, self._file.tell(), rows)))

    def sync(self) -> None:
        plain_sync(self)
        log.append(("sync", self._file.tell()))

    monkeypatch.setattr(module.Journal, "append", append)
    monkeypatch.setattr(module.Journal, "sync", sync)
    path = tmp_path / "s.h5"
    writer = SessionWriter(path, **settings(schedule))
    kept = tmp_path / "kept"
    kept.hardlink_to(journal_path(path))
    for event in session_events(schedule):
        writer.handle(event)
    writer.close()
    raw = kept.read_bytes()
    dice = random.Random(seed)
    with open_session(path) as opened:
        whole = [(run.readings, run.signal_V("force")) for run in opened.runs]
    for trial in range(6):
        broken = tmp_path / f"cut{trial}.h5"
        at = dice.randrange(1, len(log))
        image, promised = after_power_cut(raw, log[:at], dice)
        journal_path(broken).write_bytes(image)
        report = recover(broken)
        assert all(check.ok for check in verify(report.output))
        assert report.readings >= promised
        with open_session(report.output) as found:
            for run, (readings, force_V) in zip(found.runs, whole, strict=True):
                np.testing.assert_array_equal(run.readings, readings[: len(run.readings)])
                kept_V = run.signal_V("force")
                np.testing.assert_array_equal(kept_V, force_V[: len(kept_V)])


def after_power_cut(raw, log, dice):
    """The journal as a disk may hold it: synced bytes whole, pages of the rest kept or zero."""
    synced = max((end for what, end in log if what == "sync"), default=0)
    written = max((part[1] for what, part in log if what == "write"), default=synced)
    page = 4096
    image = bytearray(raw[: max(written, synced)])
    first_sync = next(iter([end for what, end in log if what == "sync"]), None)
    if first_sync is None:  # the setup is synced before the constructor returns
        synced = log[0][1][0] if log and log[0][0] == "write" else synced
    for start in range(synced, len(image), page):
        if dice.random() < 0.5:
            end = min(start + page, len(image))
            image[start:end] = bytes(end - start)
    if dice.random() < 0.5:  # the file's length was not on the disk either
        del image[dice.randrange(synced, len(image) + 1) :]
    readings = sum(
        part[2].count
        for what, part in log
        if what == "write" and part[2].path.endswith("readings") and part[1] <= synced
    )
    return bytes(image), readings


# ------------------------------------------------------------------------------------------ kills


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="SIGKILL is a POSIX signal")
@pytest.mark.parametrize(("seed", "trials"), few([(3, 1), (3, 3), (4, 3)]))
def test_a_kill_at_any_moment_loses_at_most_the_reading_being_taken(tmp_path, seed, trials):
    dice = random.Random(seed)
    for trial in range(trials):
        path = tmp_path / f"killed{trial}.h5"
        handed_over = kill_a_recording(path, after_readings=dice.randrange(1, 30))
        with pytest.raises(BadInputError, match="labrig recover"):
            open_session(path)
        report = recover(path)
        assert report.readings >= handed_over - 1
        assert report.outcome is ev.Outcome.CRASHED
        assert all(check.ok for check in verify(report.output))


def kill_a_recording(path: Path, after_readings: int) -> int:
    """Start a recording, kill it after some readings; how many it had handed to the writer."""
    program = Path(session_recording.__file__)
    process = subprocess.Popen(
        [sys.executable, str(program), str(path)], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "open\n"
    for _ in range(after_readings):
        process.stdout.readline()
    process.send_signal(signal.SIGKILL)
    rest = process.stdout.read()
    ended(process)
    process.stdout.close()
    return after_readings + rest.count("\n")


def test_what_was_recovered_is_told_with_one_reading_in_the_singular():
    report = RecoverReport(
        source=Path("cut.h5"), output=Path("cut-recovered.h5"), outcome=ev.Outcome.FAILED,
        from_journal=True, runs_completed=0, readings=1, samples=5, frames=2, notes=(),
    )  # fmt: skip
    assert report.text.endswith("0 runs complete, 1 reading, 2 frames.")
