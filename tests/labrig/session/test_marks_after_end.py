"""Runs and readings of a closed session can be marked, and the recording is proved untouched."""

from __future__ import annotations

import json
import random
import shutil
import signal
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from labrig.cli.main import run
from labrig.errors import BadInputError
from labrig.library.entry import read_entry
from labrig.library.records import with_fit
from labrig.session import (
    Mark,
    SessionWriter,
    add_mark,
    export_session,
    load_measurements,
    open_session,
    store_measurements,
    verify,
)
from labrig.session.format import layout
from labrig.session.supplements.store import seal
from protocols.execution import events as ev
from tests.cases import few
from tests.labrig.session.measured import measurements
from tests.labrig.session.session_recording import record, session_events, settings, small_schedule
from tests.processes import ended

SHORT = small_schedule(readings=1, positions_m=(0.005,))
DATA = Path(__file__).parent / "data"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("recorded") / "session.h5"
    record(path, SHORT)
    return path


@pytest.fixture
def session(recorded, tmp_path):
    return Path(shutil.copy(recorded, tmp_path / "s.h5"))


def mark(run, reading=None, why="a bubble", *, invalid=True):
    return Mark(run=run, reading=reading, why=why, who="A. P.", invalid=invalid)


def failed(path):
    return {check.name: check.found for check in verify(path) if not check.ok}


def valid(path, run=0):
    with open_session(path) as opened:
        return opened.runs[run].readings["valid"].tolist()


@pytest.mark.slow
def test_a_marked_reading_is_invalid_and_the_recording_is_as_it_was(session, recorded):
    add_mark(session, mark(0, 1))
    assert [i for i, good in enumerate(valid(session)) if not good] == [1]
    assert failed(session) == {}
    with open_session(session) as opened, open_session(recorded) as before:
        assert opened.runs[0].readings["why"][1] == "a bubble"
        (made,) = opened.marks_after_end
        assert (made.who, made.why, made.place) == ("A. P.", "a bubble", (0, 1))
        assert opened.checksum == before.checksum
        assert opened.data_checksum != before.data_checksum == before.checksum
    with h5py.File(session) as file, h5py.File(recorded) as original:
        for name in ("events", "run_000/readings", "run_000/marks", "checksums"):
            np.testing.assert_array_equal(file["session"][name][()], original["session"][name][()])


@pytest.mark.slow
def test_a_whole_run_is_marked_and_a_mark_is_taken_back_but_never_removed(session, recorded):
    add_mark(session, mark(1))
    assert not any(valid(session, 1))
    assert all(valid(session, 0))
    add_mark(session, mark(1, why="it was the other one", invalid=False))
    assert all(valid(session, 1))
    with open_session(session) as opened, open_session(recorded) as before:
        assert [m.invalid for m in opened.marks_after_end] == [True, False]
        assert opened.data_checksum == before.data_checksum
    assert failed(session) == {}


@pytest.mark.thorough
@pytest.mark.slow
def test_a_mark_of_the_session_itself_can_be_taken_back_after_its_end(tmp_path):
    path = tmp_path / "s.h5"
    with SessionWriter(path, **settings(SHORT)) as writer:
        for event in session_events(SHORT):
            writer.handle(event)
            if isinstance(event, ev.ReadingTaken) and (event.run, event.planned.index) == (0, 2):
                made = ev.ReadingMarked(event.time_s, run=0, reading=2, why="stuck", who="B")
                writer.handle(made)
    assert not valid(path)[2]
    with open_session(path) as opened:
        before = opened.data_checksum
    add_mark(path, mark(0, 2, why="it was not", invalid=False))
    assert valid(path)[2]
    with open_session(path) as opened:
        assert opened.data_checksum != before
    assert failed(path) == {}


@pytest.mark.slow
@pytest.mark.parametrize("version", few([1, 2]))
def test_sessions_of_older_versions_can_be_marked(version, tmp_path):
    path = Path(shutil.copy(DATA / f"version_{version}.hdf5", tmp_path / "old.h5"))
    add_mark(path, mark(0, 0))
    assert not valid(path)[0]
    assert failed(path) == {}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("made", "said"),
    [
        (mark(7), "there is no run 8"),
        (mark(0, 99), "reading 100 of run 1 was not acquired"),
        (mark(0, 0, invalid=False), "has no mark that could be taken back"),
    ],
)
def test_what_is_not_there_cannot_be_marked(session, made, said):
    before = session.read_bytes()
    with pytest.raises(BadInputError, match=said):
        add_mark(session, made)
    assert session.read_bytes() == before
    assert [path.name for path in session.parent.iterdir()] == ["s.h5"]


def test_a_place_is_not_marked_twice(session):
    add_mark(session, mark(0, 1))
    with pytest.raises(BadInputError, match=r"is marked already, by A\. P\.: a bubble"):
        add_mark(session, mark(0, 1, why="again"))


@pytest.mark.parametrize("text", ["", "two\nlines", "x" * 300])
def test_a_reason_that_a_file_cannot_hold_is_refused(text):
    with pytest.raises(BadInputError, match="reason of a mark"):
        mark(0, 1, why=text)


def test_a_session_that_is_not_closed_cannot_be_marked(session):
    with h5py.File(session, "r+") as file:
        file["session/outcome"][()] = b"running"
    with pytest.raises(BadInputError, match="labrig recover"):
        add_mark(session, mark(0, 1))


@pytest.mark.slow
@pytest.mark.parametrize("change", few(["why", "order", "first one gone"]))
def test_a_mark_that_was_changed_is_found_and_the_recording_still_proved(session, change):
    for reading in range(3):
        add_mark(session, mark(0, reading, why=f"reason {reading}"))
    with h5py.File(session, "r+") as file:
        table = file[f"{layout.MARKS}/entries"]
        rows = table[()]
        if change == "why":
            rows["why"][0] = b"another one"
        elif change == "order":
            rows[:2] = rows[1::-1]
        else:
            table.resize(2, axis=0)
            rows = rows[1:]
        table[...] = rows
        seal(file[layout.MARKS])  # whoever changes it writes a fitting checksum of the group
    assert failed(session) == {"marks after the end": "changed since they were made"}
    with pytest.raises(BadInputError, match="changed by another program"):
        add_mark(session, mark(1))


@pytest.mark.slow
def test_marks_that_are_damaged_leave_the_recording_proved(session):
    add_mark(session, mark(0, 1))
    with h5py.File(session, "r+") as file:
        del file[f"{layout.MARKS}/entries"]
    found = {check.name: check.ok for check in verify(session)}
    assert found["checksums"]
    assert not all(found.values())


@pytest.mark.thorough
@pytest.mark.slow
def test_programs_that_mark_at_once_all_do(session):
    threads = [
        threading.Thread(target=add_mark, args=(session, mark(0, reading))) for reading in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    with open_session(session) as opened:
        assert {m.reading for m in opened.marks_after_end} == set(range(4))
    assert failed(session) == {}
    assert [path.name for path in session.parent.iterdir()] == ["s.h5"]


MARKER = """
import sys
from pathlib import Path
from labrig.session import Mark, add_mark
print("ready", flush=True)
for n in range(1000):
    made = Mark(run=0, reading=1, why=f"n {n}", who="k", invalid=n % 2 == 0)
    add_mark(Path(sys.argv[1]), made)
"""


@pytest.mark.thorough
@pytest.mark.skipif(sys.platform == "win32", reason="needs SIGKILL")
def test_a_kill_while_marking_leaves_a_whole_session(session, recorded):
    dice = random.Random(3)
    with open_session(recorded) as before:
        checksum = before.checksum
    for _ in range(5):
        shutil.copy(recorded, session)
        process = subprocess.Popen(
            [sys.executable, "-c", MARKER, str(session)], stdout=subprocess.PIPE, text=True
        )
        assert process.stdout is not None
        process.stdout.readline()
        threading.Event().wait(0.05 + 0.4 * dice.random())
        process.send_signal(signal.SIGKILL)
        ended(process)
        process.stdout.close()
        assert failed(session) == {}
        with open_session(session) as opened:
            assert opened.checksum == checksum
            marks = opened.marks_after_end
        assert [m.why for m in marks] == [f"n {i}" for i in range(len(marks))]
        add_mark(session, mark(0, 2))  # nothing that was left keeps others from it


# -------------------------------------------------------------------------- what was made before


def analysed(path):
    with open_session(path) as opened:
        data = opened.data_checksum
    store_measurements(path, replace(measurements(), checksum=data))


@pytest.mark.thorough
@pytest.mark.slow
def test_an_analysis_of_before_is_out_of_date_until_the_mark_is_taken_back(session, tmp_path):
    analysed(session)
    assert load_measurements(session).warnings == measurements().warnings
    add_mark(session, mark(0, 1))
    with open_session(session) as opened:
        assert opened.outdated.startswith("The analysis is out of date")
    assert "out of date" in load_measurements(session).warnings[-1]
    with pytest.raises(BadInputError, match="out of date"):
        export_session(session, tmp_path / "tables")
    assert read_entry(session, "s.h5").analysis_outdated
    add_mark(session, mark(0, 1, invalid=False))
    assert not read_entry(session, "s.h5").analysis_outdated
    add_mark(session, mark(0, 1))
    analysed(session)
    assert not read_entry(session, "s.h5").analysis_outdated


@pytest.mark.slow
def test_a_fit_of_before_is_shown_as_out_of_date(session):
    entry = read_entry(session, "s.h5")
    fits = {entry.checksum: (1, {"long": {"B_Nm2": 1e-6}})}
    assert not with_fit(entry, fits).fit_outdated
    add_mark(session, mark(0, 1))
    marked = read_entry(session, "s.h5")
    assert with_fit(marked, fits).fit_outdated
    assert with_fit(marked, fits).fitted("B_Nm2") == 1e-6
    again = fits | {marked.checksum: (0, {"long": {"B_Nm2": 2e-6}})}
    assert not with_fit(marked, again).fit_outdated


# ----------------------------------------------------------------------------------- command line


def labrig(*arguments):
    return run([str(argument) for argument in arguments])


MARK = ("--run", 1, "--reading", 2, "--who", "A")


@pytest.mark.slow
def test_the_command_marks_and_show_and_list_say_so(session, capsys):
    analysed(session)
    assert labrig("mark", session, *MARK, "--why", "a bubble") == 0
    printed = capsys.readouterr().out
    assert "s.h5: run 1 (long, 5 mm), reading 2 (0 V, 1.511 mN) is invalid" in printed
    assert "out of date" in printed
    assert labrig("show", session, "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["runs"][0]["invalid"] == 1
    (made,) = shown["marks"]
    assert (made["run"], made["reading"], made["who"], made["why"]) == (1, 2, "A", "a bubble")
    assert shown["session"]["analysis"].startswith("The analysis is out of date")
    assert labrig("show", session) == 0
    assert "Marks after the end" in capsys.readouterr().out
    assert labrig("list", session.parent) == 0
    assert "s.h5: analysis out of date" in capsys.readouterr().out
    assert labrig("list", session.parent, "--json") == 0
    (entry,) = json.loads(capsys.readouterr().out)["sessions"]
    assert (entry["marks"], entry["invalid"], entry["analysis_outdated"]) == (1, 1, True)
    assert labrig("verify", session) == 0
    capsys.readouterr()
    assert labrig("mark", session, *MARK, "--why", "no", "--undo") == 0
    said = "the mark of run 1 (long, 5 mm), reading 2 (0 V, 1.511 mN) is taken back"
    assert said in capsys.readouterr().out
    with h5py.File(session) as file:
        comment = file[f"{layout.MARKS}/entries"].attrs["comment"]
    assert comment.startswith("run and reading are counted from 0; labrig show and labrig mark")
    assert all(valid(session))
    assert labrig("mark", session, "--run", 1, "--who", "A", "--why", "a leak") == 0
    assert "s.h5: run 1 (long, 5 mm) is invalid" in capsys.readouterr().out


@pytest.mark.slow
def test_a_run_is_marked_by_the_number_that_show_lists(tmp_path, capsys):
    """Of two runs only the second was measured again: they are numbered 1, 2 and 4."""
    path = tmp_path / "s.h5"
    begun = replace(SHORT, runs=(*SHORT.runs, SHORT.repeats[1]))
    with SessionWriter(path, **settings(SHORT)) as writer:
        for event in session_events(begun):
            writer.handle(event)
    assert labrig("show", path, "--json") == 0
    assert [run["run"] for run in json.loads(capsys.readouterr().out)["runs"]] == [1, 2, 4]
    assert labrig("mark", path, "--run", 3, "--why", "a leak") == 2
    assert "s.h5: there is no run 3; its runs are 1, 2, 4." in capsys.readouterr().err
    assert labrig("mark", path, "--run", 4, "--why", "a leak") == 0
    assert "s.h5: run 4 (short, 5 mm) is invalid" in capsys.readouterr().out
    with open_session(path) as opened:
        assert not opened.run(3).readings["valid"].any()
        assert opened.run(1).readings["valid"].all()


def test_the_command_names_what_is_wrong_in_a_sentence(session, capsys):
    assert labrig("mark", session, "--run", 9, "--why", "x") == 2
    assert "there is no run 9" in capsys.readouterr().err
    assert labrig("mark", session, "--run", 1, "--why", " ") == 2
    assert "reason of a mark" in capsys.readouterr().err
