"""Disk, files and whoever watches a run go wrong: told, recoverable, and at 0 V."""

from __future__ import annotations

import errno
import os
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from labrig.cli.follow import RunDisplay
from labrig.session import open_session
from labrig.session.recording import writer
from labrig.session.recording.journal import Journal
from protocols.execution.event_bus import EventBus
from protocols.execution.events import Event, Outcome, OutputState, ReadingTaken
from sim_hardware.world import World
from tests.end_to_end.faulty_rig import FaultyRig, spied_writes
from tests.end_to_end.small_rig import labrig

pytestmark = pytest.mark.slow


@pytest.fixture
def rig(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> FaultyRig:
    return FaultyRig(tmp_path, capsys, spied_writes(monkeypatch))


def when_driven(monkeypatch: pytest.MonkeyPatch, act: Callable[[], object]) -> None:
    """Do something as soon as the first voltage is on the sheet."""
    real = World.__init__

    def init(self: World, *arguments: Any, **options: Any) -> None:
        real(self, *arguments, **options)
        self.when_first_driven(lambda _when: act())

    monkeypatch.setattr(World, "__init__", init)


def test_a_full_disk_ends_the_run_at_0_V_and_what_came_before_is_recovered(
    rig: FaultyRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = Journal.append

    def append(self: Journal, rows: Any) -> None:
        if rows.path.endswith("readings") and rows.at == 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        real(self, rows)

    monkeypatch.setattr(Journal, "append", append)
    left = rig.run()
    assert left.code == 5
    last = left.said.strip().splitlines()[-1]
    assert last.startswith("labrig: The output is at 0 V, read back. The session can no longer be")
    assert "the disk is full" in last
    assert left.said.count(f"run: labrig recover {left.path}") == 1
    assert "Traceback" not in left.said
    assert left.board_V == 0.0
    whole = left.path.with_name("whole.h5")
    assert labrig("recover", left.path, "-o", whole) == 0
    with open_session(whole) as session:
        assert session.outcome is Outcome.CRASHED
        assert len(session.runs[0].readings) == 2


def test_a_disk_that_never_answers_at_the_end_is_not_waited_for(
    rig: FaultyRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = Journal.remove
    never = threading.Event()
    threads = []

    def remove(self: Journal) -> None:
        threads.append(threading.current_thread())
        never.wait(30.0)
        real(self)

    monkeypatch.setattr(writer, "CLOSE_S", 3.0)
    monkeypatch.setattr(Journal, "remove", remove)
    left = rig.run()
    never.set()
    threads[0].join(5.0)
    assert left.code == 5
    assert "the disk has not answered for 3 s" in left.said
    assert left.board_V == 0.0


@pytest.mark.skipif(sys.platform == "win32", reason="Windows deletes no open file")
def test_a_session_that_is_deleted_under_the_run_comes_back_from_its_journal(
    rig: FaultyRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = rig.folder / "rig" / "s.h5"
    when_driven(monkeypatch, path.unlink)
    left = rig.run()
    assert left.code == 5
    assert "can no longer be recorded" in left.said
    assert "Traceback" not in left.said
    assert left.board_V == 0.0
    assert labrig("recover", path, "-o", path.with_name("whole.h5")) == 0
    with open_session(path.with_name("whole.h5")) as session:
        assert len(session.runs[0].readings) == 5


@pytest.mark.thorough
@pytest.mark.skipif(sys.platform == "win32", reason="Windows renames no folder of open files")
def test_a_folder_that_is_renamed_under_the_run_is_named(
    rig: FaultyRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = rig.folder / "rig"
    moved = folder.with_name("moved")
    when_driven(monkeypatch, lambda: folder.rename(moved))
    left = rig.run()
    assert left.code == 5
    assert f"the folder {folder} was removed or renamed" in left.said
    assert left.board_V == 0.0
    assert labrig("recover", moved / "s.h5", "-o", moved / "whole.h5") == 0


@pytest.mark.thorough
@pytest.mark.skipif(sys.platform == "win32", reason="a lock of POSIX")
def test_a_session_that_another_program_locks_is_recorded_all_the_same(
    rig: FaultyRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    import fcntl

    held = []

    def lock_new(folder: Path) -> None:
        file = (folder / "s.h5").open("rb")
        fcntl.flock(file, fcntl.LOCK_EX)
        held.append(file)

    monkeypatch.setattr(writer, "sync_folder", lock_new)
    left = rig.run(look=False)
    for file in held:
        file.close()
    assert left.code == 0, left.said
    assert left.board_V == 0.0
    assert labrig("verify", left.path) == 0


@pytest.mark.parametrize("number", [errno.EACCES, errno.EROFS])
def test_a_folder_that_cannot_be_written_is_found_before_the_first_voltage(
    rig: FaultyRig, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    real = Path.open

    def refuse(self: Path, mode: str = "r", *arguments: Any, **options: Any) -> Any:
        if "x" in mode:
            raise OSError(number, os.strerror(number), str(self))
        return real(self, mode, *arguments, **options)

    monkeypatch.setattr(Path, "open", refuse)
    left = rig.run()
    assert left.code == 2
    assert f"cannot be written: {os.strerror(number)}" in left.said
    assert left.outcome is None
    assert left.highest_V == 0.0


@pytest.mark.thorough
def test_a_display_that_raises_changes_nothing_but_is_told(
    rig: FaultyRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(self: RunDisplay, event: Event) -> None:
        raise RuntimeError("no terminal")

    monkeypatch.setattr(RunDisplay, "__call__", broken)
    left = rig.run()
    assert (left.code, left.outcome, left.readings) == (0, Outcome.COMPLETED, 5)
    assert left.invalid == []
    assert left.warnings == [
        "the progress display failed and may show too little: RuntimeError: no terminal"
    ]


def test_a_display_that_blocks_holds_up_nothing(
    rig: FaultyRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    never = threading.Event()

    def stuck(self: RunDisplay, event: Event) -> None:
        if isinstance(event, ReadingTaken):
            never.wait(60.0)

    monkeypatch.setattr(RunDisplay, "__call__", stuck)
    monkeypatch.setattr("labrig.cli.follow.EventBus", lambda **_: EventBus(threaded=True))
    left = rig.run()
    never.set()
    assert (left.code, left.outcome, left.readings) == (0, Outcome.COMPLETED, 5)
    assert left.output is OutputState.SAFE
    assert left.invalid == []


@pytest.mark.thorough
def test_the_time_of_day_that_jumps_back_changes_no_measured_time(
    rig: FaultyRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    times = iter(["2026-11-21T12:00:00.000+00:00", "2026-11-21T11:00:00.000+00:00"])
    monkeypatch.setattr("protocols.execution.scheduler.utc_now", lambda: next(times))
    left = rig.run()
    assert (left.code, left.invalid) == (0, [])
    with open_session(left.path) as session:
        times_s = session.runs[0].readings["time_s"]
        assert (times_s[1:] > times_s[:-1]).all()
