"""Notes and photographs are added to a session and change nothing of the recording."""

from __future__ import annotations

import random
import shutil
import signal
import subprocess
import sys
import threading
from pathlib import Path

import h5py
import numpy as np
import pytest

from labrig.errors import BadInputError, LabrigError
from labrig.session import (
    Note,
    SessionWriter,
    add_note,
    open_session,
    recover,
    store_measurements,
    verify,
)
from labrig.session.notes import waiting as waiting_module
from labrig.session.notes.note import PHOTOGRAPH_BYTES_MAX
from labrig.session.notes.waiting import open_waiting, waiting_path
from labrig.session.recording.journal import journal_path
from tests.cases import few
from tests.labrig.session.measured import measurements
from tests.labrig.session.session_recording import record, session_events, settings, small_schedule


def note(text: str = "the sheet looks dry", **more: object) -> Note:
    return Note(who="A. Operator", text=text, **more)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("annotated") / "s.h5"
    record(path, small_schedule(positions_m=(0.0,)))
    return path


@pytest.fixture
def closed(recorded, tmp_path):
    return Path(shutil.copy(recorded, tmp_path / "s.h5"))


def texts_of(path, **how):
    with open_session(path, **how) as session:
        return [one.text for one in session.notes]


def failed(path):
    return [check.name for check in verify(path) if not check.ok]


def checksum_of(path):
    with open_session(path) as session:
        return session.checksum


@pytest.mark.slow
def test_a_note_on_a_closed_session_is_in_the_file_and_the_recording_is_untouched(closed):
    before = checksum_of(closed)
    assert add_note(closed, note("first"))
    assert add_note(closed, note("second"))
    assert texts_of(closed) == ["first", "second"]
    assert checksum_of(closed) == before
    assert not failed(closed)
    assert not waiting_path(closed).exists()


@pytest.mark.slow
def test_a_photograph_comes_back_byte_by_byte(closed):
    content = bytes(range(256)) * 10
    add_note(closed, Note(who="", text="", media_type="image/png", photograph=content))
    with open_session(closed) as session:
        (found,) = session.notes
        assert (found.has_photograph, found.photograph) == (True, b"")
        assert session.photograph(found.identifier) == content
        with pytest.raises(BadInputError, match="no such photograph"):
            session.photograph("another")


@pytest.mark.slow
@pytest.mark.parametrize("what", few(["author", "description", "date", "sequence_index", "data"]))
def test_verify_finds_a_note_that_was_changed(closed, what):
    add_note(closed, note("before", media_type="image/png", photograph=b"abc"))
    add_note(closed, note("after"))
    with h5py.File(closed, "r+") as file:
        item = file[f"session/notes/note_0001/{what}"]
        item[...] = item[()] + 1 if item.dtype.kind in "iu" else np.bytes_(b"forged")
    assert failed(closed) == ["notes"]


@pytest.mark.slow
def test_verify_finds_a_note_that_was_taken_out(closed):
    add_note(closed, note("before"))
    add_note(closed, note("after"))
    with h5py.File(closed, "r+") as file:
        del file["session/notes/note_0001"]
    assert failed(closed) == ["notes"]


@pytest.mark.slow
def test_nothing_is_added_to_notes_that_another_program_has_changed(closed):
    add_note(closed, note("before"))
    with h5py.File(closed, "r+") as file:
        file["session/notes/note_0001/author"][()] = b"forged"
    with pytest.raises(BadInputError, match="changed by another program"):
        add_note(closed, note("after"))
    assert texts_of(closed) == ["before"]
    assert not waiting_path(closed).exists()
    assert failed(closed) == ["notes"]


@pytest.mark.slow
def test_a_note_during_a_run_is_on_the_disk_at_once_and_in_the_file_at_the_close(tmp_path):
    path = tmp_path / "s.h5"
    events = list(session_events(small_schedule(positions_m=(0.0,))))
    writer = SessionWriter(path, **settings(small_schedule(positions_m=(0.0,))))
    for event in events[:40]:
        writer.handle(event)
    assert not add_note(path, note("while it runs"))
    assert texts_of(path, live=True) == ["while it runs"]
    for event in events[40:]:
        writer.handle(event)
    writer.close()
    assert not waiting_path(path).exists()
    with h5py.File(path) as file:
        assert "note_0001" in file["session/notes"]
    assert texts_of(path) == ["while it runs"]
    assert not failed(path)


def killed_while_recording(path):
    """A session whose program was killed with SIGKILL after some readings."""
    command = [sys.executable, "-m", "tests.labrig.session.session_recording", str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        for line in program.stdout:
            if line.startswith("0 1"):
                break
        add_note(path, note("just before the kill"))
        program.send_signal(signal.SIGKILL)


@pytest.mark.slow
@pytest.mark.parametrize("in_place", few([True, False]))
def test_a_kill_loses_no_note_and_recover_doubles_none(tmp_path, in_place):
    path = tmp_path / "s.h5"
    killed_while_recording(path)
    add_note(path, note("after the kill"))
    wanted = ["just before the kill", "after the kill"]
    output = recover(path, in_place=in_place).output
    assert texts_of(output) == wanted
    assert not failed(output)
    assert waiting_path(path).exists() is not in_place  # the original stays as it was
    if in_place:
        add_note(path, note("later"))
        assert texts_of(path) == [*wanted, "later"]


@pytest.mark.thorough
@pytest.mark.slow
def test_a_kill_between_file_and_clearing_doubles_no_note(closed, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(waiting_module.WaitingNotes, "clear", lambda _self: None)
        add_note(closed, note("once"))
    assert waiting_path(closed).exists()
    assert texts_of(closed) == ["once"]
    add_note(closed, note("twice"))
    assert texts_of(closed) == ["once", "twice"]
    assert not failed(closed)


@pytest.mark.slow
def test_a_note_that_the_file_does_not_take_is_kept_beside_it_and_added_later(
    closed, monkeypatch, tmp_path
):
    def full(*_args: object, **_more: object) -> None:
        raise LabrigError("the disk is full")

    with monkeypatch.context() as patch:
        patch.setattr("labrig.session.notes.add.replaced", full)
        assert not add_note(closed, note("first"))
    assert texts_of(closed) == ["first"]
    assert add_note(closed, note("second"))
    assert texts_of(closed) == ["first", "second"]
    assert not waiting_path(closed).exists()


@pytest.mark.thorough
@pytest.mark.slow
def test_a_note_and_an_analysis_at_the_same_time_are_both_in_the_file(closed):
    threads = [
        threading.Thread(target=add_note, args=(closed, note(f"note {k}"))) for k in range(3)
    ] + [threading.Thread(target=store_measurements, args=(closed, measurements()))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(texts_of(closed)) == 3
    with open_session(closed) as session:
        assert session.has_measurements
    assert not failed(closed)


@pytest.mark.slow
def test_what_waits_beside_a_whole_session_is_added_by_recover_in_place(closed):
    with open_session(closed) as session:
        identifier = session.identifier
    with open_waiting(closed, make=True) as waiting:
        waiting.append(note("left behind"), identifier)
    assert texts_of(closed) == ["left behind"]
    recover(closed, in_place=True)
    assert not waiting_path(closed).exists()
    assert texts_of(closed) == ["left behind"]


@pytest.mark.slow
def test_a_record_that_was_torn_by_a_kill_costs_itself_alone(closed):
    with open_session(closed) as session:
        identifier = session.identifier
    with open_waiting(closed, make=True) as waiting:
        waiting.append(note("whole"), identifier)
        waiting.append(note("torn"), identifier)
    with waiting_path(closed).open("r+b") as file:
        file.truncate(file.seek(0, 2) - 3)
    assert texts_of(closed) == ["whole"]
    add_note(closed, note("next"))
    assert texts_of(closed) == ["whole", "next"]


def test_notes_of_another_session_are_not_taken_for_those_of_this_one(closed):
    with open_waiting(closed, make=True) as waiting:
        waiting.append(note("foreign"), "another session")
    assert texts_of(closed) == []
    with pytest.raises(BadInputError, match="another session"):
        add_note(closed, note())
    closed.unlink()
    with pytest.raises(BadInputError, match="earlier session"):
        SessionWriter(closed, **settings(small_schedule()))
    assert not journal_path(closed).exists()


@pytest.mark.thorough
@pytest.mark.slow
def test_notes_from_many_threads_at_once_are_all_kept(closed):
    threads = [
        threading.Thread(target=add_note, args=(closed, note(f"note {k}"))) for k in range(8)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(texts_of(closed)) == [f"note {k}" for k in range(8)]
    assert not failed(closed)


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        ({"text": " "}, "needs a text or a photograph"),
        ({"text": "x" * 10_001}, "too long"),
        ({"text": "a\0b"}, "control character"),
        ({"text": "a\ud800"}, "control character"),
        ({"who": "w" * 121}, "too long"),
        ({"photograph": bytes(PHOTOGRAPH_BYTES_MAX + 1)}, "too large"),
    ],
)
def test_what_is_no_note_is_refused_with_its_reason(wrong, why):
    with pytest.raises(BadInputError, match=why):
        Note(**({"who": "A", "text": "t"} | wrong))


@pytest.mark.slow
def test_notes_of_a_session_of_an_older_format_have_a_checksum_too(tmp_path):
    path = Path(shutil.copy(Path(__file__).parent / "data" / "version_2.hdf5", tmp_path / "s.h5"))
    add_note(path, note("years later"))
    assert not failed(path)
    with h5py.File(path, "r+") as file:
        file["session/notes/note_0001/description"][()] = b"forged"
    assert failed(path) == ["notes"]


@pytest.mark.parametrize(
    "seed", [*range(6), *(pytest.param(seed, marks=pytest.mark.thorough) for seed in range(6, 20))]
)
def test_damage_of_what_waits_costs_no_note_before_it_and_raises_nothing(closed, seed):
    with open_session(closed) as session:
        identifier = session.identifier
    texts = [f"note {k}" for k in range(5)]
    with open_waiting(closed, make=True) as waiting:
        for text in texts:
            waiting.append(note(text), identifier)
    raw = bytearray(waiting_path(closed).read_bytes())
    at = random.Random(seed).randrange(len(raw))
    raw[at] ^= 1 << (seed % 8)
    waiting_path(closed).write_bytes(raw)
    found = texts_of(closed)
    assert found == texts[: len(found)]
    assert len(found) >= at * 6 // len(raw) - 1  # the record that names the session comes first
