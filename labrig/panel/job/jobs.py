"""The panel's side of a job: start, find, follow and ask it. A panel never ends a job."""

from __future__ import annotations

import subprocess
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from labrig.errors import LabrigError
from labrig.panel.errors import NotNowError, UnreachableError
from labrig.panel.job import Order
from labrig.panel.job.connection import JobConnection
from labrig.panel.job.process import JobProcesses
from labrig.panel.job.registry import ENDED, GOING, LOST, JobAddress, read_address
from labrig.panel.live.event_stream import EventStream, Message
from labrig.panel.live.frame_pipeline import FramePipeline
from labrig.panel.live.packing import BrokenConnectionError, Header
from labrig.panel.live.run_phase import RunPhase
from labrig.panel.live.strip_chart import strip_from
from labrig.session.reading.guard_report import GuardReport, forget_guard_report, read_guard_report

POLL_S = 0.3
START_S = 30.0  # a busy computer imports slowly
_LOST = (
    "the process of this job has ended without a message; the guard writes 0 V then. Press STOP to "
    "have the output read, and run labrig recover on the session."
)


class Jobs:
    """One job at a time in a data folder. The job outlives the panel and these threads."""

    def __init__(
        self,
        data: Path,
        stream: EventStream,
        frame_pipeline: FramePipeline,
        rig: Path | None = None,
        on_setup: Callable[[Message | None], None] = lambda _: None,
    ) -> None:
        """`on_setup` is told of camera and strips, as the frame pipeline is; it must not wait."""
        self._data = data
        self._processes = JobProcesses(data, rig)
        self._stream = stream
        self._frame_pipeline = frame_pipeline
        self._on_setup = on_setup
        self._connection: JobConnection | None = None
        self._address: JobAddress | None = None
        self._process: subprocess.Popen[bytes] | None = None
        # The guard's report that was published last, and its job: a guard that could not read 0 V
        # back keeps trying, and reports again when it has.
        self._guarded: tuple[str, GuardReport] | None = None
        self._starting = False
        self._phase = RunPhase()
        self._lock = threading.Lock()
        self._changed = threading.Event()
        self._closed = False
        self._thread = threading.Thread(target=self._watch, name="panel-jobs", daemon=True)
        self._thread.start()

    @property
    def address(self) -> JobAddress | None:
        """The job that is going on, or the last one."""
        return self._address

    @property
    def going(self) -> bool:
        """Whether a job has the rig."""
        return self._starting or (self._address is not None and self._address.state == GOING)

    def message(self) -> Message | None:
        """Return the job as pages see it."""
        return None if self._address is None else self._address.message()

    def start(self, order: Order) -> Message:
        """Start a job and wait until it can be followed. Raises NotNowError, LabrigError."""
        with self._lock:
            if self.going:
                raise NotNowError("a job is going on already; wait for its end, or stop it.")
            self._starting, self._phase = True, RunPhase()
        try:
            _forget_old_guard(order)
            self._process = process = self._processes.begin(order)
            self._wait_for(order, process)
        finally:
            self._starting = False
        message = self.message()
        assert message is not None  # noqa: S101 - for the type checker
        return message

    def ask(self, what: Header) -> None:
        """Ask the job for something. Raises LabrigError with its answer, or that there is none."""
        connection = self._connection
        if connection is None:
            raise NotNowError("no job is going on.")
        try:
            answer = connection.ask(what)
        except BrokenConnectionError as error:
            raise UnreachableError(f"the job does not answer: {error}.") from None
        if answer.get("error"):
            raise NotNowError(str(answer["error"]))

    def note(self, who: str, what: str) -> None:
        """Into the session's log, if there is one going on."""
        if self._connection is not None:
            with suppress(LabrigError):
                self.ask({"do": "note", "who": who, "what": what})

    def close(self) -> None:
        """Stop following; the job continues."""
        self._closed = True
        self._changed.set()
        if self._connection is not None:
            self._connection.close()
        self._processes.close()
        self._thread.join(2.0)

    # -------------------------------------------------------------------------- in threads of ours

    def _watch(self) -> None:
        while not self._closed:
            if self._connection is None:
                self._find_job()
            self._read_guard()
            if self._process is not None:
                self._process.poll()  # so that a job of ours that has ended is no zombie
            self._prepare()
            self._changed.wait(POLL_S)
            self._changed.clear()

    def _prepare(self) -> None:
        """Have a process ready for the next job, but take no time from the start and the pulses."""
        if not self.going:
            self._processes.prepare()
        elif self._phase.begun and not self._phase.pulses:
            self._processes.prepare(beside_a_job=True)

    def _find_job(self) -> None:
        """Connect to the job that the data folder names, if there is one."""
        found = read_address(self._data)
        if found is None or (self._address is not None and found == self._address):
            return
        if found.state == GOING:
            if (
                self._address is not None
                and self._address.id == found.id
                and self._address.state == LOST
            ):
                return
            self._address = found
            try:
                self._connection = JobConnection(
                    found.port, found.key, "panel", self._on_message, self._on_end
                )
            except OSError:
                self._lose(found)
            return
        if self._address is None or self._address.id != found.id:
            self._stream.publish_story([found.message()])  # it ended before we were there
        self._address = found

    def _on_message(self, header: Header, payload: memoryview) -> None:
        kind = header.get("type")
        if kind == "story":
            messages = header["messages"]
            self._phase = _phase_of(messages)
            setups = [m for m in messages if m["type"] == "setup"]
            self._set_setup(setups[-1] if setups else None)
            self._stream.publish_story([m for m in messages if m["type"] != "setup"])
        elif kind == "setup":
            self._set_setup(header)
        elif kind == "picture":
            self._frame_pipeline.put((header, bytes(payload)))
        elif kind == "signals":
            with suppress(ValueError, KeyError):
                self._stream.publish_strip(strip_from(header, payload))
        else:
            if kind == "job":
                self._note_end(header)
            self._phase.take(header)
            self._stream.publish(header)

    def _set_setup(self, setup: Message | None) -> None:
        self._frame_pipeline.set_setup(setup)
        self._on_setup(setup)

    def _note_end(self, job: Header) -> None:
        """Note that the job has ended, though its process may still be telling others."""
        address = self._address
        if address is not None and job.get("id") == address.id and job.get("state") == ENDED:
            self._address = address.ended(job.get("code"), str(job.get("text", "")))

    def _on_end(self) -> None:
        address, self._connection = self._address, None
        found = read_address(self._data)
        if found is not None and address is not None and found.id == address.id:
            if found.state == GOING:
                self._lose(found)
            else:
                self._address = found
        self._changed.set()

    def _lose(self, address: JobAddress) -> None:
        self._address = address.ended(None, _LOST, LOST)
        messages = [m for m in self._stream.messages() if m["type"] != "job"]
        self._stream.publish_story([*messages, self._address.message(), _output("unknown", _LOST)])
        self._guarded = None
        self._read_guard()

    def _read_guard(self) -> None:
        """Publish the guard's report of a job that hangs or is gone: it has written 0 V."""
        address = self._address
        if address is None or address.session is None or address.state == ENDED:
            return
        report = read_guard_report(self._data / address.session)
        if report is None or self._guarded == (address.id, report):
            return
        self._guarded = (address.id, report)
        if address.state == LOST:
            self._address = address.ended(None, _lost_text(report), LOST)
            self._stream.publish(self._address.message())
        state = "safe" if report.is_safe else "unknown"
        self._stream.publish({**_output(state, report.text), "by": "guard"})

    def _wait_for(self, order: Order, process: subprocess.Popen[bytes]) -> None:
        """Until it is followed, or has ended."""
        waited = threading.Event()
        for _ in range(round(START_S / 0.05)):
            self._changed.set()
            if self._address is not None and self._address.id == order.id:
                return
            ended = process.poll() is not None
            waited.wait(0.05)
            if ended and (self._address is None or self._address.id != order.id):
                raise LabrigError(f"the job did not start; see {self._data}/.labrig/job.log.")
        raise LabrigError(f"the job did not start in {START_S:g} s; is the computer overloaded?")


def _phase_of(story: list[Message]) -> RunPhase:
    phase = RunPhase()
    for message in story:
        phase.take(message)
    return phase


def _forget_old_guard(order: Order) -> None:
    """Forget the guard report of an earlier session of this name."""
    if order.session is not None and not Path(order.session).exists():
        forget_guard_report(Path(order.session))


def _lost_text(report: GuardReport) -> str:
    return f"{report.text}. Run labrig recover on the session."


def _output(state: str, why: str) -> Message:
    return {"type": "output", "time_s": None, "state": state, "why": why, "log": why}
