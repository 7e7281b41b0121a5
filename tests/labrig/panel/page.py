"""A panel as a process, and pages that speak with it as a browser does."""

from __future__ import annotations

import http.client
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from labrig.panel.live.packing import unpack

Message = dict[str, Any]
# On a busy computer the preflight refuses a camera that cannot keep up: then once more.
TRIES, TOO_BUSY = 4, "camera rate"


LEAN = Path(__file__).with_name("lean_panel.py")


class Server:
    """`labrig panel` as a process.

    `lean`: without what takes longer than most runs of tests, the fit beside a run and a process
    that is ready for the next job; for tests of something else.
    """

    def __init__(self, what: Path | None, *options: str, lean: bool = False) -> None:
        shown = [] if what is None else [str(what)]
        program = ["-P", str(LEAN)] if lean else ["-m", "labrig"]
        port = () if "--port" in options else ("--port", "0")
        command = [sys.executable, *program, "panel", *shown, *port, *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout is not None
        self.address = self.process.stdout.readline().strip()
        parts = urlsplit(self.address)
        self.netloc = parts.netloc
        self.origin = f"{parts.scheme}://{parts.netloc}"
        self.token = parts.query.removeprefix("token=")

    def ask(
        self,
        method: str,
        path: str,
        body: Any = None,
        headers: dict[str, str] | None = None,
        *,
        as_browser: bool = True,
        netloc: str | None = None,
    ) -> tuple[int, Any]:
        """One request; status and what came back (parsed where it is JSON)."""
        own = {"Cookie": f"labrig_token={self.token}", "Origin": self.origin} if as_browser else {}
        connection = http.client.HTTPConnection(netloc or self.netloc, timeout=60)
        try:
            sent = body if body is None or isinstance(body, bytes) else json.dumps(body).encode()
            kind = {"Content-Type": "application/json"}
            connection.request(method, path, sent, {**kind, **own, **(headers or {})})
            answer = connection.getresponse()
            content = answer.read()
            if "json" in answer.headers.get("Content-Type", ""):
                return answer.status, json.loads(content)
            return answer.status, content
        finally:
            connection.close()

    def end(self, how: int = signal.SIGINT) -> None:
        """End it, by this signal."""
        if self.process.poll() is None:
            self.process.send_signal(how)
        self.process.wait(20)
        if self.process.stdout is not None:
            self.process.stdout.close()


class Page:
    """A page with its socket open; reads all the time, in a thread."""

    def __init__(self, server: Server, path: str = "/ws", *, reads: bool = True) -> None:
        self.server = server
        headers = {"Cookie": f"labrig_token={server.token}"}
        self._context = connect(
            f"ws://{server.netloc}{path}",
            origin=server.origin,  # type: ignore[arg-type]
            additional_headers=headers,
            max_size=64 << 20,
            max_queue=4 if not reads else None,
        )
        self.socket = self._context.__enter__()
        self.hello: Message = json.loads(self.socket.recv(timeout=20))
        self.client = self.hello.get("client", "")
        self.messages: list[Message] = []  # since the last story, its own included
        self.stories = 0
        self.first_replay: Message = {}  # with its marks; a story does not take it away
        self.pictures: list[Message] = []
        self.strips: list[tuple[Message, bytes]] = []
        self.closed: ConnectionClosed | None = None
        self._changed = threading.Condition()
        if reads:
            threading.Thread(target=self._read, daemon=True).start()

    def ask(self, method: str, path: str, body: Any = None) -> tuple[int, Any]:
        """One request of this page."""
        return self.server.ask(method, path, body, {"X-Labrig-Client": self.client})

    def do(self, path: str, **body: Any) -> Any:
        """A request that must go well."""
        status, answer = self.ask("POST", path, body)
        assert status == 200, answer
        return answer

    def take_control(self, name: str = "Ann", *, force: bool = False) -> Any:
        """Take control."""
        return self.do("/api/control", do="take", name=name, force=force)

    def until(self, wanted: Callable[[Message], bool] | str, timeout_s: float = 60.0) -> Message:
        """The last message of a type, or that fulfils something, once it is there."""
        fits = wanted if callable(wanted) else (lambda m: m["type"] == wanted)
        end_s = time.monotonic() + timeout_s
        with self._changed:
            while True:
                for message in reversed(self.messages):
                    if fits(message):
                        return message
                left_s = end_s - time.monotonic()
                assert left_s > 0, f"it did not come: {self._lately()}"
                assert self.closed is None, str(self.closed)
                self._changed.wait(left_s)

    def _lately(self) -> str:
        """What came last, and how a job has ended."""
        kinds = [m["type"] for m in self.messages[-20:]]
        return f"{kinds} {[m['text'] for m in self.messages if m['type'] == 'job']}"

    def ended(self, job: Message) -> Message:
        """The end of the job that began with this answer: the story of one before may be there."""
        return self.until(
            lambda m: m["type"] == "job" and m["id"] == job["id"] and m["state"] != "going"
        )

    def of(self, kind: str) -> list[Message]:
        """All messages of a type."""
        with self._changed:
            return [m for m in self.messages if m["type"] == kind]

    def say(self, **word: Any) -> None:
        """Say something on the socket."""
        self.socket.send(json.dumps(word))

    def close(self) -> None:
        """Close the page."""
        with suppress(Exception):
            self.socket.close()

    def _read(self) -> None:
        try:
            for packed in self.socket:
                with self._changed:
                    self._note(packed)
                    self._changed.notify_all()
        except ConnectionClosed as closed:
            self.closed = closed
        with self._changed:
            self.closed = self.closed or ConnectionClosed(None, None)
            self._changed.notify_all()

    def _note(self, packed: str | bytes) -> None:
        if isinstance(packed, bytes):
            header, payload = unpack(packed)
            if header["type"] == "picture":
                self.pictures.append({**header, "bytes": bytes(payload), "came_s": time.time()})
                self.say(do="seen", image=header["image"])
            else:
                self.strips.append((header, bytes(payload)))
            return
        message = json.loads(packed)
        if message["type"] == "story":
            self.stories += 1
            self.messages = list(message["messages"])
            self.strips = []
        else:
            self.messages.append(message)
            if "marks" in message:
                self.first_replay = message


def begin(page: Page, session: str, protocol: str = "long.toml") -> Message:
    """Have a run started; what the page knows is of this run alone from then on."""
    job: Message = page.do("/api/run", protocol=protocol, session=session, clock="real")
    page.until(lambda m: m["type"] == "job" and m["id"] == job["id"])
    return job


def start(page: Page, session: str, protocol: str = "long.toml") -> Message:
    """Start a run of one position and answer all that is asked before it."""
    for _ in range(TRIES):
        job = begin(page, session, protocol)
        first = page.until(lambda m: m["type"] == "prompt" or m.get("state") == "ended")
        if first["type"] == "prompt":
            break
        assert TOO_BUSY in first["text"]
    for number in (1, 2, 3):
        page.until(lambda m, n=number: m["type"] == "prompt" and m["prompt"] == n)  # type: ignore[misc]
        page.do("/api/answer", prompt=number, done=True)
    page.until("run_started")
    return job


@contextmanager
def panel(
    what: Path | None, *options: str, leave_job: bool = False, lean: bool = False
) -> Iterator[Server]:
    """A panel until the block ends; its job ends with it unless it is to be left.

    Without `what`: a panel of sessions, which has no job.
    """
    server = Server(what, *options, lean=lean)
    try:
        yield server
    finally:
        server.end()
        for pid in [] if leave_job or what is None else jobs_of(what.parent):
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGTERM)


@contextmanager
def killed_job(data: Path) -> Iterator[None]:
    """Kill the process of the job that is going on, as a crash would.

    The simulated boards outlive it: they are ended after the block.
    """
    (pid,) = jobs_of(data)
    started = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    os.kill(pid, signal.SIGKILL)
    yield
    for one in started:
        with suppress(ProcessLookupError):
            os.kill(int(one), signal.SIGTERM)


def jobs_of(data: Path) -> list[int]:
    """The process of a job that is still going on in a data folder."""
    try:
        place = json.loads((data / ".labrig" / "job.json").read_text())
    except (OSError, ValueError):
        return []
    return [place["pid"]] if place["state"] == "going" else []
