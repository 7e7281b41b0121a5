"""Pause after a position and go on, from a page and from the command line."""

from __future__ import annotations

import subprocess
import sys
import time

import pytest

from labrig.cli.main import run
from labrig.experiment.pause import PauseFile
from labrig.session import open_session
from tests.labrig.panel.page import Page
from tests.labrig.session.session_recording import record, small_schedule

pytestmark = pytest.mark.slow
POSITIONS = """
[pulse_train]
zero_readings = 2
readings_per_voltage = 2
[[places]]
configuration = "long"
positions_mm = [0, 10, 20, 30]
[extras]
mode = "paper"
"""


@pytest.fixture
def page(server, rig_folder):
    (rig_folder / "positions.toml").write_text(POSITIONS)
    found = Page(server)
    found.take_control(force=True)
    yield found
    found.close()


def paused(page, session):
    """A run that is paused after one of its first positions; the answer to its start."""
    job = page.do("/api/run", protocol="positions.toml", session=session, clock="virtual")
    page.until(lambda m: m["type"] == "job" and m["id"] == job["id"])
    page.until("run_started")
    page.do("/api/pause", on=True)
    page.until(lambda m: m["type"] == "state" and m["state"] == "paused")
    return job


def test_a_paused_run_is_safe_and_completes_when_it_is_continued(page, rig_folder):
    job = paused(page, "paused.h5")
    assert page.until("output")["state"] == "safe"
    begun = len(page.of("run_started"))
    time.sleep(1.0)  # noqa: TID251 - another process is watched
    assert len(page.of("run_started")) == begun < 4
    page.do("/api/pause", on=False)
    assert page.ended(job)["code"] == 0
    with open_session(rig_folder / "paused.h5") as session:
        assert session.outcome == "completed"
        assert len(session.runs) == 4
        log = [event.text for event in session.events]
    at = [number for number, text in enumerate(log) if "paused the session after run" in text]
    assert len(at) == 1
    assert any("0 V written and read back" in text for text in log[: at[0]])
    assert any("labrig continues with run" in text for text in log[at[0] :])


def test_stop_ends_a_paused_run(page):
    job = paused(page, "paused-stopped.h5")
    page.do("/api/stop", why="enough")
    ended = page.ended(job)
    assert ended["code"] == 4
    assert page.until("ended")["output"] == "safe"


def test_without_control_nobody_pauses(page, server):
    other = Page(server)
    try:
        status, answer = other.ask("POST", "/api/pause", {"on": True})
        assert status == 403, answer
    finally:
        other.close()


@pytest.mark.thorough
def test_another_terminal_pauses_a_session(rig_folder, tmp_path):
    (rig_folder / "positions.toml").write_text(POSITIONS)
    session = tmp_path / "terminal.h5"
    files = [rig_folder / name for name in ("rig.toml", "positions.toml", "sheet.toml")]
    command = [sys.executable, "-m", "labrig", "run", *files, "-o", session]
    going = subprocess.Popen(command, stderr=subprocess.PIPE)
    try:
        while not session.exists():
            assert going.poll() is None, going.stderr.read()
            time.sleep(0.05)  # noqa: TID251 - another process is watched
        assert run(["pause", str(session)]) == 0
        assert PauseFile(session).asked_by()
        time.sleep(4.0)  # noqa: TID251 - longer than all the runs take
        assert going.poll() is None, going.stderr.read()
        assert run(["pause", "--end", str(session)]) == 0
        assert going.wait(60) == 0
    finally:
        going.kill()
        going.stderr.close()
    assert not PauseFile(session).asked_by()


def test_a_session_that_is_over_cannot_pause(tmp_path, capsys):
    session = tmp_path / "over.h5"
    record(session, small_schedule(1))
    assert run(["pause", str(session)]) == 2
    assert "nothing can pause" in capsys.readouterr().err
