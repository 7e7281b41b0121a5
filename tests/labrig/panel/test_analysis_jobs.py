"""Analysis jobs: queued, each in a process that may be cancelled, may crash, and gives way."""

from __future__ import annotations

import os
import queue
import signal
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

from labrig.errors import BadInputError
from labrig.panel.analysis.__main__ import sentence_of
from labrig.panel.analysis.jobs import AnalysisJobs
from labrig.panel.analysis.order import AnalysisOrder
from labrig.panel.analysis.process import AnalysisProcess
from labrig.panel.errors import MissingError, NotNowError
from labrig.panel.processes import LOWER_BY, LOWEST_PRIORITY
from labrig.session import SessionWriter, open_session
from model import ModelError
from tests.labrig.session.session_recording import record, settings, small_schedule

WAIT_S = 120.0  # on a shared machine; nothing waits longer than it must
posix = pytest.mark.skipif(sys.platform == "win32", reason="reads POSIX priorities")


class Heard:
    """The messages that pages get."""

    def __init__(self):
        self._changed = threading.Condition()
        self.jobs = {}
        self.states = []

    def __call__(self, message):
        with self._changed:
            for job in message["jobs"]:
                if self.jobs.get(job["id"], {}).get("state") != job["state"]:
                    self.states.append((job["kind"], job["state"]))
                self.jobs[job["id"]] = job
            self._changed.notify_all()

    def until(self, job, *states, step=""):
        end_s = time.monotonic() + WAIT_S
        with self._changed:
            while True:
                found = self.jobs.get(job["id"], job)
                if found["state"] in states and step in found["step"]:
                    return found
                assert self._changed.wait(end_s - time.monotonic()), found


@contextmanager
def analysis_jobs(folder, run_is_on=lambda: False):
    heard = Heard()
    jobs = AnalysisJobs(folder, heard, run_is_on)
    try:
        yield jobs, heard
    finally:
        jobs.close()


def started(jobs, session, kind="analyze"):
    return jobs.start(kind, session, session.name, "Ann", "2026-11-23T00:00:00+00:00")


def is_alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.slow
def test_a_cancelled_job_is_ended_at_once_and_leaves_the_session_as_it_was(session):
    before = session.read_bytes()
    with analysis_jobs(session.parent) as (jobs, heard):
        job = started(jobs, session)
        heard.until(job, "running", step="mm")  # in the middle of its work
        pid = jobs._process.pid
        began_s = time.monotonic()
        assert jobs.cancel(job["id"])["state"] == "cancelled"
        assert time.monotonic() - began_s < 2.0
        assert not is_alive(pid)
        assert heard.until(job, "cancelled")["message"] == "It was cancelled."
        with pytest.raises(NotNowError, match="ended already"):
            jobs.cancel(job["id"])
    assert session.read_bytes() == before
    assert [path.name for path in session.parent.glob("session*")] == ["session.h5"]


@pytest.mark.thorough
@pytest.mark.slow
def test_a_process_that_is_killed_is_a_failed_job_with_a_sentence_and_the_next_one_begins(session):
    bare = session.with_name("bare.h5")
    record(bare, small_schedule(2), texts={})
    with analysis_jobs(session.parent) as (jobs, heard):
        crashing, waiting = started(jobs, session), started(jobs, bare, "fit")
        heard.until(crashing, "running")
        assert heard.until(waiting, "queued")
        os.kill(jobs._process.pid, signal.SIGKILL)
        found = heard.until(crashing, "failed")
        assert "ended without an outcome" in found["message"]
        assert "Traceback" not in found["message"]
        ended = heard.until(waiting, "failed")  # in a sentence of its own
        assert "holds no sheet.toml" in ended["message"]
    assert heard.states.index(("analyze", "failed")) < heard.states.index(("fit", "running"))


@pytest.mark.parametrize(
    ("error", "says"),
    [
        (BadInputError("it is too short."), "it is too short."),
        (ModelError("nothing was measured"), "nothing was measured."),
        (MemoryError(), "not enough memory"),
        (ZeroDivisionError("division\n by zero"), "(ZeroDivisionError: division by zero)"),
    ],
)
def test_whatever_goes_wrong_is_one_sentence(error, says):
    sentence = sentence_of(error)
    assert says in sentence
    assert "\n" not in sentence


@pytest.mark.slow
def test_jobs_wait_for_each_other_and_the_same_one_is_not_queued_twice(session):
    with analysis_jobs(session.parent) as (jobs, heard):
        first, second = started(jobs, session), started(jobs, session, "fit")
        with pytest.raises(NotNowError, match=r"fit of session\.h5 is under way"):
            started(jobs, session, "fit")
        heard.until(first, "running")
        assert heard.until(second, "queued")
        assert jobs.cancel(second["id"])["state"] == "cancelled"
        jobs.cancel(first["id"])
        with pytest.raises(MissingError):
            jobs.cancel("nobody")
    assert ("fit", "running") not in heard.states


@pytest.mark.slow
def test_a_session_that_is_being_recorded_is_not_analysed(tmp_path):
    with (
        SessionWriter(tmp_path / "now.h5", **settings(small_schedule(2))),
        analysis_jobs(tmp_path) as (jobs, _),
        pytest.raises(NotNowError, match="is being recorded"),
    ):
        started(jobs, tmp_path / "now.h5")


@posix
@pytest.mark.slow
@pytest.mark.parametrize("when", ["before the job", "while the job is going on"])
def test_a_job_has_a_low_priority_while_a_run_is_on(session, when):
    begun = threading.Event()
    own = os.getpriority(os.PRIO_PROCESS, 0)
    if when == "before the job":
        begun.set()
    with analysis_jobs(session.parent, begun.is_set) as (jobs, heard):
        heard.until(started(jobs, session), "running")
        pid = jobs._process.pid
        if not begun.is_set():
            assert os.getpriority(os.PRIO_PROCESS, pid) == own
            begun.set()
        wanted, end_s = min(LOWEST_PRIORITY, own + LOWER_BY), time.monotonic() + WAIT_S
        while os.getpriority(os.PRIO_PROCESS, pid) != wanted:
            assert time.monotonic() < end_s
            threading.Event().wait(0.02)
        session_priority = Path(f"/proc/{pid}/autogroup")  # Linux, where sessions share the cores
        if session_priority.exists():
            assert session_priority.read_text().endswith(f"nice {wanted}\n")


@pytest.mark.slow
@posix
def test_a_process_ends_with_the_panel_that_started_it(session):
    process = AnalysisProcess(AnalysisOrder(kind="analyze", session=str(session)), session.parent)
    while process.message(WAIT_S)["step"] == "":
        pass
    process._process.stdin.close()  # as the system does when the panel is killed
    while process.message(WAIT_S) is not None:
        pass
    assert process.end() == -signal.SIGKILL
    with open_session(session) as opened:
        assert not opened.has_measurements


@pytest.mark.thorough
@pytest.mark.slow
def test_a_part_that_the_process_of_an_analysis_leaves_out_is_told(session, tmp_path, monkeypatch):
    site = tmp_path / "site"
    info = site / "labrig_blind-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: labrig-blind\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[labrig.extractors]\nblind = labrig_nowhere:NONE\n")
    path = os.pathsep.join(filter(None, [str(site), os.environ.get("PYTHONPATH", "")]))
    monkeypatch.setenv("PYTHONPATH", path)
    heard, told = Heard(), queue.Queue()
    jobs = AnalysisJobs(session.parent, heard, lambda: False, told.put)
    try:
        started(jobs, session)
        text = told.get(timeout=WAIT_S)
    finally:
        jobs.close()
    assert "'blind' of labrig-blind (labrig_nowhere:NONE) is left out: loading it failed" in text
