"""The journal, and a writer whose disk fails."""

from __future__ import annotations

import subprocess
import sys
import threading
from itertools import chain
from pathlib import Path

import h5py
import numpy as np
import pytest

from labrig.errors import BadInputError, ExitCode
from labrig.session import SessionWriter, WriterError, open_session, recover
from labrig.session.recording.journal import Journal, journal_path, read_journal
from labrig.session.recording.rows import EventRows, Translator
from labrig.session.recording.write_queue import StalledError, WriteQueue
from protocols.execution import events as ev
from tests.labrig.session import session_recording
from tests.labrig.session.session_recording import (
    session_events,
    settings,
    setup_of,
    small_schedule,
)


@pytest.fixture(scope="module")
def setup():
    return setup_of(settings(small_schedule()))


@pytest.fixture(scope="module")
def some_rows(setup):
    translator = Translator(setup)
    return [rows for event in session_events(setup.schedule) for rows in translator.rows(event)]


def write(path, setup, rows):
    journal = Journal(path, setup)
    for each in rows:
        journal.append(each)
    journal.close()


def test_all_that_was_written_is_read_again(tmp_path, setup, some_rows):
    write(tmp_path / "j", setup, some_rows)
    journal = read_journal(tmp_path / "j")
    assert journal.setup == setup
    assert list(journal.rows()) == some_rows
    assert journal.whole_bytes() == (tmp_path / "j").stat().st_size


@pytest.mark.slow
def test_reading_ends_before_the_first_damaged_byte(tmp_path, setup, some_rows):
    rows = some_rows[:40]
    write(tmp_path / "j", setup, rows)
    raw = (tmp_path / "j").read_bytes()
    begin = read_journal(tmp_path / "j").first_row
    for at in np.linspace(begin, len(raw) - 1, 60).astype(int):
        damaged = bytearray(raw)
        damaged[at] ^= 0x40
        (tmp_path / "j").write_bytes(damaged)
        journal = read_journal(tmp_path / "j")
        found = list(journal.rows())
        assert found == rows[: len(found)]
        assert len(found) < len(rows)
        assert journal.whole_bytes() <= at


def test_a_record_out_of_order_is_no_record(tmp_path, setup, some_rows):
    write(tmp_path / "a", setup, some_rows[:3])
    write(tmp_path / "b", setup, some_rows[:3])
    raw, first = (tmp_path / "a").read_bytes(), read_journal(tmp_path / "a").first_row
    (tmp_path / "a").write_bytes(raw + raw[first:])
    assert len(list(read_journal(tmp_path / "a").rows())) == 3


def test_a_journal_without_a_whole_beginning_is_none(tmp_path, setup):
    write(tmp_path / "j", setup, [])
    (tmp_path / "j").write_bytes((tmp_path / "j").read_bytes()[:-1])
    assert read_journal(tmp_path / "j") is None
    assert read_journal(tmp_path / "none") is None


def test_a_journal_left_by_a_crash_is_not_written_over(tmp_path, setup):
    write(journal_path(tmp_path / "s.h5"), setup, [])
    with pytest.raises(BadInputError, match="labrig recover"):
        SessionWriter(tmp_path / "s.h5", **settings(small_schedule()))
    assert not (tmp_path / "s.h5").exists()


# ------------------------------------------------------------------------------------- the queue


def test_a_consumer_that_is_stuck_is_noticed_while_items_come():
    backlog = WriteQueue[int](limit_bytes=1000, patience_s=0.05)
    backlog.put(1, 1)
    assert backlog.take(1.0) == 1
    threading.Event().wait(0.1)
    with pytest.raises(StalledError, match="not answered"):
        backlog.put(2, 1)


def test_a_full_queue_waits_for_room_and_then_gives_up():
    backlog = WriteQueue[int](limit_bytes=10, patience_s=0.05)
    backlog.put(1, 8)
    with pytest.raises(StalledError, match="full"):
        backlog.put(2, 8)
    taker = threading.Timer(0.02, backlog.take, [1.0])
    taker.start()
    backlog.put(3, 8)
    taker.join()


def test_an_item_larger_than_the_queue_passes_alone():
    backlog = WriteQueue[str](limit_bytes=10, patience_s=0.05)
    backlog.put("big", 1000)
    assert backlog.take(1.0) == "big"


# ------------------------------------------------------------------------------- a disk that fails


def send_until_it_fails(writer, seconds=20.0):
    """Hand over events until WriterError comes back; its text."""
    pause = threading.Event()
    more = (ev.Warned(0.0, "still there?") for _ in range(int(seconds / 0.01)))
    try:
        for event in chain(session_events(small_schedule()), more):
            writer.handle(event)
            pause.wait(0.01 if isinstance(event, ev.Warned) else 0.0)
    except WriterError as error:
        return error
    raise AssertionError("the writer never failed")


def failing_after(method, calls, error):
    count = 0

    def fail(*args, **named):
        nonlocal count
        count += 1
        if count > calls:
            raise error
        return method(*args, **named)

    return fail


@pytest.mark.slow
@pytest.mark.parametrize(("what", "after", "kept"), [("append", 600, 4), ("sync", 1, 0)])
def test_a_full_disk_stops_the_session_with_a_sentence_and_keeps_what_was_written(
    tmp_path, monkeypatch, what, after, kept
):
    full = OSError(28, "No space left on device")
    method = getattr(Journal, what)
    monkeypatch.setattr(Journal, what, failing_after(method, after, full))
    path = tmp_path / "s.h5"
    writer = SessionWriter(path, **settings(small_schedule()))
    error = send_until_it_fails(writer)
    assert "the disk is full" in str(error)
    assert f"labrig recover {path}" in str(error)
    assert error.code is ExitCode.FAILED
    with pytest.raises(WriterError):
        writer.close()
    writer.close()
    monkeypatch.undo()
    assert recover(path).readings >= kept


@pytest.mark.slow
def test_an_error_of_the_hdf5_library_is_put_in_words(tmp_path, monkeypatch):
    text = "Can't write data (file write failed: errno = 28, error message = 'No space left ...')"
    monkeypatch.setattr(
        h5py.Dataset, "resize", failing_after(h5py.Dataset.resize, 20, OSError(text))
    )
    with SessionWriter(tmp_path / "s.h5", **settings(small_schedule())) as writer:
        assert "the disk is full" in str(send_until_it_fails(writer))
        monkeypatch.undo()
        with pytest.raises(WriterError):
            writer.close()


@pytest.mark.slow
def test_a_disk_that_does_not_answer_is_noticed(tmp_path, monkeypatch):
    answer = threading.Event()
    plain = Journal.append

    def slow(self, rows: EventRows) -> None:
        answer.wait(5.0)
        plain(self, rows)

    monkeypatch.setattr(Journal, "append", slow)
    settings_ = settings(small_schedule()) | {"patience_s": 0.1}
    writer = SessionWriter(tmp_path / "s.h5", **settings_)
    error = send_until_it_fails(writer)
    answer.set()
    assert "not answered" in str(error)
    with pytest.raises(WriterError):
        writer.close()
    writer._thread.join()
    # Events were turned away, so the file must not claim to be whole.
    with pytest.raises(BadInputError, match="labrig recover"):
        open_session(tmp_path / "s.h5")


@pytest.mark.slow
def test_nothing_can_be_recorded_after_the_close(tmp_path):
    writer = SessionWriter(tmp_path / "s.h5", **settings(small_schedule()))
    writer.close()
    with pytest.raises(WriterError, match="closed"):
        writer.handle(ev.Warned(0.0, "late"))


@pytest.mark.slow
def test_a_recording_that_nobody_ended_has_failed(tmp_path):
    SessionWriter(tmp_path / "s.h5", **settings(small_schedule())).close()
    with open_session(tmp_path / "s.h5") as session:
        assert session.outcome is ev.Outcome.FAILED
        assert "without saying" in session.reason


LIMITED = """
import resource, signal, sys
sys.path.insert(0, sys.argv[2])
import session_recording as made
from labrig.session import SessionWriter, WriterError
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (600_000, 600_000))
from pathlib import Path
schedule = made.small_schedule(readings=4)
writer = SessionWriter(Path(sys.argv[1]), **made.settings(schedule))
try:
    for event in made.session_events(schedule):
        writer.handle(event)
    writer.close()
except WriterError as error:
    print("said:", error)
"""


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="limits of a process are POSIX")
def test_when_the_system_refuses_more_bytes_what_came_before_is_kept(tmp_path):
    path = tmp_path / "s.h5"
    folder = str(Path(session_recording.__file__).parent)
    command = [sys.executable, "-c", LIMITED, str(path), folder]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.stdout.startswith("said: The session can no longer be recorded")
    report = recover(path)
    assert report.readings >= 4
    with open_session(report.output) as session:
        assert session.runs[0].frame(0) is not None
