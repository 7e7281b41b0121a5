"""The connection between a job and its panels: TCP on this computer, opened by a key.

The job's side (`JobConnectionServer`) publishes its event stream to every client and answers
requests, with threads for each. The client's side is `JobConnection`. Standard library only: the
STOP process uses it, too.
"""

from __future__ import annotations

import hmac
import itertools
import secrets
import socket
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Protocol

from labrig.panel.live.packing import BrokenConnectionError, Header, pack, receive, send

GREETING_S = 2.0
ASK_S = 3.0
MOST_LISTENERS = 16
MOST_ASKED_BYTES = 1 << 16
HERE = "127.0.0.1"


class Publisher(Protocol):
    """Sends the job's messages to one client; made for each connection."""

    def run(self, send_it: Callable[[bytes], None]) -> None:
        """Send all there is until `close`; raises OSError when the follower has gone."""

    def close(self) -> None:
        """Send what is left, then return from `run`: the client has gone, or the job ends."""


Do = Callable[[Header], Header | None]


class JobConnectionServer:
    """The job's side. `do` is called with what is asked, in the asker's thread."""

    def __init__(self, do: Do, publisher: Callable[[str], Publisher]) -> None:
        self._do = do
        self._publisher = publisher
        self.key = secrets.token_urlsafe(24)
        self._socket = socket.create_server((HERE, 0))
        self.port: int = self._socket.getsockname()[1]
        self._publishers: dict[Publisher, threading.Thread] = {}
        self._lock = threading.Lock()
        threading.Thread(target=self._accept, name="job-server", daemon=True).start()

    def close(self, timeout_s: float) -> None:
        """Send the last messages to all clients that still read, then close."""
        self._socket.close()
        with self._lock:
            publishers = dict(self._publishers)
        for publisher in publishers:
            publisher.close()
        for thread in publishers.values():
            thread.join(timeout_s)

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._socket.accept()
            except OSError:
                return
            if len(self._publishers) >= MOST_LISTENERS:
                connection.close()
                continue
            threading.Thread(
                target=self._serve, args=(connection,), name="job-requests", daemon=True
            ).start()

    def _serve(self, connection: socket.socket) -> None:
        with suppress(OSError, BrokenConnectionError), connection:
            role = self._greet(connection)
            if role is None:
                return
            # A client that reads nothing blocks its own thread alone; its mailbox has a bound.
            connection.settimeout(None)
            lock = threading.Lock()

            def send_it(packed: bytes) -> None:
                with lock:
                    send(connection, packed)

            publisher = self._publisher(role)
            thread = threading.Thread(
                target=_publish_until_end,
                args=(publisher, connection, send_it),
                name="job-publisher",
                daemon=True,
            )
            with self._lock:
                self._publishers[publisher] = thread
            thread.start()
            try:
                self._answer_requests(connection, send_it)
            finally:
                publisher.close()
                with self._lock:
                    self._publishers.pop(publisher, None)

    def _greet(self, connection: socket.socket) -> str | None:
        connection.settimeout(GREETING_S)
        asked, _ = receive(connection, MOST_ASKED_BYTES)
        if not hmac.compare_digest(str(asked.get("key", "")).encode(), self.key.encode()):
            return None
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return str(asked.get("role", ""))

    def _answer_requests(self, connection: socket.socket, send_it: Callable[[bytes], None]) -> None:
        while True:
            asked, _ = receive(connection, MOST_ASKED_BYTES)
            answer = self._do(asked) or {}
            send_it(pack({**answer, "type": "reply", "ask": asked.get("ask")}))


def _publish_until_end(
    publisher: Publisher, connection: socket.socket, send_it: Callable[[bytes], None]
) -> None:
    try:
        publisher.run(send_it)
    except OSError:
        pass
    finally:
        with suppress(OSError):
            connection.shutdown(socket.SHUT_RDWR)


class JobConnection:
    """The other side. `on_message` is called in a thread of its own, `on_end` once, at the end."""

    def __init__(
        self,
        port: int,
        key: str,
        role: str,
        on_message: Callable[[Header, memoryview], None],
        on_end: Callable[[], None],
    ) -> None:
        """Connect. Raises OSError when nobody is there."""
        self._connection = socket.create_connection((HERE, port), GREETING_S)
        self._connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._connection.settimeout(None)
        self._on_message = on_message
        self._on_end = on_end
        self._numbers = itertools.count(1)
        self._waiting: dict[int, _Answer] = {}
        self._lock = threading.Lock()
        self.alive = True
        send(self._connection, pack({"key": key, "role": role}))
        threading.Thread(target=self._listen, name=f"job-{role}", daemon=True).start()

    def ask(self, what: Header, timeout_s: float = ASK_S) -> Header:
        """Ask for something and wait for the answer. Raises BrokenConnectionError."""
        number, answer = next(self._numbers), _Answer()
        self._waiting[number] = answer
        try:
            with self._lock:
                send(self._connection, pack({**what, "ask": number}))
            if not answer.came.wait(timeout_s):
                raise BrokenConnectionError(f"no answer came in {timeout_s:g} s")
        except OSError as error:
            raise BrokenConnectionError(str(error)) from None
        finally:
            self._waiting.pop(number, None)
        if answer.header is None:
            raise BrokenConnectionError("the other side has gone")
        return answer.header

    def close(self) -> None:
        """Go."""
        with suppress(OSError):
            self._connection.shutdown(socket.SHUT_RDWR)
        self._connection.close()

    def _listen(self) -> None:
        try:
            with suppress(OSError, BrokenConnectionError):
                while True:
                    self._take(*receive(self._connection))
        finally:
            self.alive = False
            for answer in list(self._waiting.values()):
                answer.came.set()
            self._on_end()

    def _take(self, header: Header, payload: memoryview) -> None:
        if header.get("type") != "reply":
            self._on_message(header, payload)
            return
        answer = self._waiting.get(header.get("ask", 0))
        if answer is not None:
            answer.header = header
            answer.came.set()


class _Answer:
    def __init__(self) -> None:
        self.came = threading.Event()
        self.header: dict[str, Any] | None = None
