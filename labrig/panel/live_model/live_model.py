"""The dynamic model beside the run: what happens goes to its process, what it says to the pages.

One batch is under way at a time. What comes meanwhile waits in a mailbox with a bound: of curves
the newest, of signals the last minute. So a slow process skips images and holds nothing up.
"""

from __future__ import annotations

import queue
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path

import numpy as np

from labrig.panel.live.event_stream import (
    CURVE,
    MOTION,
    EventStream,
    Mail,
    Mailbox,
    Message,
    Picture,
)
from labrig.panel.live.packing import BrokenConnectionError, Header, pack, read, write
from labrig.panel.live.strip_chart import SIGNALS, StripChart, strip_from
from labrig.panel.processes import (
    end_with_children,
    in_background,
    lower_priority,
    module_environment,
)

EVERY_S = 0.04  # a batch, at most
START_S = 120.0  # a process at low priority imports and compiles slowly on a busy computer
ANSWER_S = 20.0
MOST_STARTS = 4  # of a process that dies; then there is no model beside the run any more
_WANTED = frozenset({"plan", "run_started", "voltage", "load_cell", "run_stopped"})
Answer = tuple[Header, memoryview]


class LiveModel:
    """Follows one stream until it is closed. Other methods than `close` never wait."""

    def __init__(self, stream: EventStream) -> None:
        self._stream = stream
        self._news = threading.Event()
        self._box = _RunMailbox(self._news.set)
        self._path: Path | None = None
        self._setup: Message | None = None
        self._changed = True  # setup or model, which the process does not know yet
        self._closed = False
        self._process: _ModelProcess | None = None
        self._starts = 0
        self._failed = ""
        self._thread = threading.Thread(target=self._follow, name="panel-live-model", daemon=True)
        self._thread.start()

    def set_setup(self, setup: Message | None) -> None:
        """Set the camera and the strips."""
        self._setup = setup
        self._changed = True
        self._news.set()

    def choose_model(self, path: Path | None) -> None:
        """Take another model; it begins with the next run."""
        self._path, self._starts, self._failed = path, 0, ""
        self._changed = True
        self._news.set()

    def close(self) -> None:
        """End thread and process."""
        self._closed = True
        self._news.set()
        process = self._process
        if process is not None:
            process.end()
        self._thread.join(5.0)

    # ---------------------------------------------------------------------------- in our thread

    def _follow(self) -> None:
        self._stream.join(self._box)
        wait = threading.Event()
        while not self._closed:
            self._news.wait()
            self._news.clear()
            if self._path is not None and self._changed and not self._failed:
                self._take(Mail())  # so that it has begun when a run begins
            while not self._closed and (mail := self._box.take()) is not None:
                self._take(mail)
            wait.wait(EVERY_S)
        self._stream.leave(self._box)
        if self._process is not None:
            self._process.end()

    def _take(self, mail: Mail) -> None:
        if self._path is None:
            if self._process is not None:
                self._end_process()
                self._publish_none("")
            return
        if self._failed:
            return
        process = self._process or self._started()
        if process is None:
            return
        try:
            self._tell_model(process)
            if mail.story is not None:
                process.ask({"messages": [{"type": "story"}]})
            batch, payload = _batch(mail)
            if batch is not None:
                self._publish(*process.ask(batch, payload))
        except _ModelLostError as error:
            self._lose(str(error))
        except Exception as error:  # noqa: BLE001 - the page must learn of it, whatever it is
            self._lose(f"cannot go on ({type(error).__name__}: {error})")

    def _lose(self, why: str) -> None:
        self._end_process()
        again = self._starts < MOST_STARTS
        self._failed = "" if again else why
        rest = "it is started again" if again else "it is not started again"
        self._publish_none(f"The model beside the run {why}; {rest}. The run goes on.")

    def _started(self) -> _ModelProcess | None:
        self._starts += 1
        try:
            self._process = _ModelProcess()
        except OSError as error:
            self._failed = str(error)
            self._publish_none(f"The model beside the run cannot be started ({error}).")
            return None
        self._changed = True
        return self._process

    def _tell_model(self, process: _ModelProcess) -> None:
        if not self._changed:
            return
        self._changed = False
        told: list[Message] = [{"type": "model", "path": str(self._path)}]
        if self._setup is not None:
            told.append(self._setup)
        # what has happened so far in this session, for a model that is chosen in the middle of it
        story = [m for m in self._stream.messages() if m["type"] in _WANTED]
        self._publish(*process.ask({"messages": [*told, {"type": "story"}, *story]}))

    def _end_process(self) -> None:
        if self._process is not None:
            self._process.end()
            self._process = None

    def _publish(self, answer: Header, payload: memoryview) -> None:
        self._stream.publish_newest(answer["motion"])
        if answer.get("estimates") is not None:
            self._stream.publish_newest(answer["estimates"])
        if answer.get("strip") is not None:
            self._stream.publish_strip(strip_from(answer["strip"], payload))

    def _publish_none(self, why: str) -> None:
        self._stream.publish_newest({"type": MOTION, "state": "none", "why": why, "run": None})


def _batch(mail: Mail) -> tuple[Header | None, bytes]:
    """Return what of a mail the model needs to know; None: nothing."""
    messages = [m for m in [*(mail.story or ()), *mail.messages] if m["type"] in _WANTED]
    curve = next((m for m in mail.newest if m["type"] == CURVE), None)
    strip = mail.strip
    if not messages and curve is None and strip is None:
        return None, b""
    header: Header = {"messages": messages, "curve": curve, "strip": None}
    if strip is None:
        return header, b""
    header["strip"] = strip.header()
    return header, np.ascontiguousarray(strip.values, dtype="<f4").tobytes()


class _RunMailbox(Mailbox):
    """Messages, curves and what was measured."""

    def put_strip(self, strip: StripChart) -> None:
        """Leave out what was predicted: it comes from here."""
        if strip.kind == SIGNALS:
            super().put_strip(strip)

    def put_newest(self, message: Message) -> None:
        """Take curves only."""
        if message["type"] == CURVE:
            super().put_newest(message)

    def put_picture(self, picture: Picture) -> None:
        """Leave it out."""


class _ModelLostError(Exception):
    """The process has ended, or does not answer; the text follows 'the model beside the run'."""


class _ModelProcess:
    """The process, with a thread that hears it: a process that hangs holds up nobody for long."""

    def __init__(self) -> None:
        """Start it. Raises OSError."""
        self._process = subprocess.Popen(
            [sys.executable, "-m", "labrig.panel.live_model"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=module_environment(),
            **in_background(),
        )
        lower_priority(self._process.pid)
        self._has_answered = False
        self._answers: queue.Queue[Answer | None] = queue.Queue()
        threading.Thread(target=self._hear, name="panel-live-model-reader", daemon=True).start()

    @property
    def pid(self) -> int:
        """Its number."""
        return self._process.pid

    def ask(self, batch: Header, payload: bytes = b"") -> Answer:
        """Return the answer to a batch. Raises _ModelLostError."""
        assert self._process.stdin is not None  # noqa: S101 - for the type checker
        try:
            write(self._process.stdin, pack(batch, payload))
            within_s = ANSWER_S if self._has_answered else START_S
            answer = self._answers.get(timeout=within_s)
        except queue.Empty:
            raise _ModelLostError(f"has not answered for {within_s:g} s") from None
        except (OSError, ValueError):
            answer = None
        if answer is None:
            raise _ModelLostError("has ended without a word")
        self._has_answered = True
        return answer

    def end(self) -> None:
        """End it at once."""
        end_with_children(self._process.pid)
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                with suppress(OSError, ValueError):
                    stream.close()

    def _hear(self) -> None:
        assert self._process.stdout is not None  # noqa: S101 - for the type checker
        with suppress(OSError, ValueError, BrokenConnectionError):
            while True:
                self._answers.put(read(self._process.stdout))
        self._answers.put(None)
