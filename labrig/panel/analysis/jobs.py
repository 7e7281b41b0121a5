"""Analysis jobs of one panel: queued, one at a time, each in a process of its own."""

from __future__ import annotations

import os
import queue
import secrets
import threading
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from labrig.errors import LabrigError
from labrig.panel.analysis.order import AnalysisKind, AnalysisOrder
from labrig.panel.analysis.outputs import output_path
from labrig.panel.analysis.process import AnalysisProcess, Message
from labrig.panel.errors import MissingError, NotNowError
from labrig.session.recording.journal import journal_path
from labrig.session.recording.locking import is_locked

State = Literal["queued", "running", "done", "failed", "cancelled"]
POLL_S = 0.3  # for a run that begins meanwhile
MOST_QUEUED = 20
MOST_KEPT = 50  # jobs that have ended
MOST_WORKERS = 4


@dataclass(kw_only=True)
class AnalysisJob:
    """One job; pages see all but `order`."""

    id: str
    kind: AnalysisKind
    session: str  # its name in the data folder
    by: str
    wall: str
    order: AnalysisOrder
    state: State = "queued"
    step: str = ""
    fraction: float = 0.0
    message: str = ""  # how it ended, one sentence
    result: dict[str, Any] = field(default_factory=dict)  # {"files": {...}, "notes": [...]}

    def as_dict(self) -> Message:
        """For JSON."""
        shown = ("id", "kind", "session", "by", "wall", "state", "step", "fraction", "message")
        return {**{name: getattr(self, name) for name in shown}, "result": self.result}


class AnalysisJobs:
    """`publish` is called with each change, `run_is_on` asks whether the rig is in use."""

    def __init__(
        self,
        hidden: Path,
        publish: Callable[[Message], None],
        run_is_on: Callable[[], bool],
        left_out: Callable[[str], None] = lambda _: None,
    ) -> None:
        """`left_out` is told of parts that a process could not use."""
        self._hidden = hidden
        self._left_out = left_out
        self._publish = publish
        self._run_is_on = run_is_on
        self._jobs: list[AnalysisJob] = []
        self._process: AnalysisProcess | None = None
        self._changed = threading.Condition()
        self._closed = False
        self._thread = threading.Thread(target=self._work, name="panel-analysis", daemon=True)
        self._thread.start()

    def message(self) -> Message:
        """Return all jobs as pages see them, newest last."""
        with self._changed:
            return {"type": "analysis", "jobs": [job.as_dict() for job in self._jobs]}

    def start(
        self,
        kind: AnalysisKind,
        session: Path,
        name: str,
        by: str,
        wall: str,
        between: tuple[str, str] | None = None,
    ) -> Message:
        """Queue a job. Raises NotNowError where that makes no sense now."""
        if is_locked(journal_path(session)):
            raise NotNowError(f"{name} is being recorded; analyse it when its run has ended.")
        order = AnalysisOrder(kind=kind, session=str(session), between=between)
        job = AnalysisJob(
            id=secrets.token_hex(8), kind=kind, session=name, by=by, wall=wall, order=order
        )
        with self._changed:
            self._require_room(job)
            self._jobs.append(job)
            self._forget_old()
            self._changed.notify_all()
        self._tell()
        return job.as_dict()

    def cancel(self, job_id: str) -> Message:
        """Cancel a job that waits or runs; its process ends at once. Raises MissingError."""
        with self._changed:
            job = next((one for one in self._jobs if one.id == job_id), None)
            if job is None:
                raise MissingError("there is no such analysis job.")
            if job.state not in ("queued", "running"):
                raise NotNowError("this analysis job has ended already.")
            process = self._process if job.state == "running" else None
            job.state, job.step, job.message = "cancelled", "", "It was cancelled."
            if process is not None:
                process.end()
        self._tell()
        return job.as_dict()

    def close(self) -> None:
        """End the process; what is queued is forgotten."""
        with self._changed:
            self._closed = True
            self._jobs.clear()
            if self._process is not None:
                self._process.end()
            self._changed.notify_all()
        self._thread.join(5.0)

    # ---------------------------------------------------------------------------- with the lock

    def _require_room(self, job: AnalysisJob) -> None:
        waiting = [one for one in self._jobs if one.state in ("queued", "running")]
        if any((one.kind, one.session) == (job.kind, job.session) for one in waiting):
            raise NotNowError(f"{job.kind} of {job.session} is under way already.")
        if len(waiting) >= MOST_QUEUED:
            raise NotNowError(f"{MOST_QUEUED} analysis jobs are waiting; let some end first.")

    def _forget_old(self) -> None:
        ended = [one for one in self._jobs if one.state not in ("queued", "running")]
        for job in ended[: max(0, len(ended) - MOST_KEPT)]:
            self._jobs.remove(job)

    # ---------------------------------------------------------------------------- in our thread

    def _work(self) -> None:
        while (job := self._next()) is not None:
            self._do(job)

    def _next(self) -> AnalysisJob | None:
        """Return the next job once there is one; None: the panel ends."""
        with self._changed:
            while not self._closed:
                job = next((one for one in self._jobs if one.state == "queued"), None)
                if job is not None:
                    return job
                self._changed.wait()
            return None

    def _do(self, job: AnalysisJob) -> None:
        process = self._begin(job)
        self._tell()
        if process is None:
            return
        while True:
            if not process.is_low and self._run_is_on():
                process.lower()
            try:
                message = process.message(POLL_S)
            except queue.Empty:
                continue
            if message is None:
                break
            if message["type"] == "left_out":
                self._left_out(message["text"])
            else:
                self._note(job, message)
        self._finish(job, process)
        self._tell()

    def _begin(self, job: AnalysisJob) -> AnalysisProcess | None:
        """Start the job's process; None where it was cancelled, or cannot be started."""
        run_is_on = self._run_is_on()
        workers = 1 if run_is_on else max(1, min(MOST_WORKERS, os.cpu_count() or 1))
        with self._changed:
            if job.state != "queued" or self._closed:
                return None
            try:
                process = AnalysisProcess(replace(job.order, workers=workers), self._hidden)
            except LabrigError as error:
                job.state, job.message = "failed", str(error)
                return None
            if run_is_on:
                process.lower()
            self._process, job.state, job.step = process, "running", "starting"
            return process

    def _note(self, job: AnalysisJob, message: Message) -> None:
        with self._changed:
            if job.state != "running":
                return
            if message["type"] == "progress":
                job.step, job.fraction = message["step"], message["fraction"]
            elif message["type"] == "done":
                session = Path(job.order.session)
                files = {name: output_path(session, name).name for name in message["files"]}
                job.result = {"files": files, "notes": message["notes"]}
                job.state, job.fraction, job.message = "done", 1.0, message["message"]
                job.step = ""
            else:
                job.state, job.step, job.message = "failed", "", message["message"]
        self._tell()

    def _finish(self, job: AnalysisJob, process: AnalysisProcess) -> None:
        with self._changed:
            code = process.end()
            self._process = None
            job.step = ""
            if job.state == "running":
                job.state, job.message = "failed", _why_it_ended(code)

    def _tell(self) -> None:
        self._publish(self.message())


def _why_it_ended(code: int) -> str:
    how = f"by signal {-code}" if code < 0 else f"with code {code}"
    return (
        f"its process has ended without an outcome ({how}; perhaps memory was short): start it "
        "again, and see .labrig/analysis.log of the data folder if that happens again."
    )
