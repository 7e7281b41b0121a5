"""What every job has: an event stream for panels, and an address where they find it."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from labrig.errors import LabrigError
from labrig.panel.job.connection import JobConnectionServer
from labrig.panel.job.order import Order
from labrig.panel.job.registry import JobAddress, write_address
from labrig.panel.live.event_stream import EventStream, Mail, Mailbox, Message
from labrig.panel.live.packing import Header, pack

Handler = Callable[[dict[str, Any]], object]

_FAREWELL_S = 2.0
_FOR_STOP = frozenset({"output", "job", "ended"})


class Host:
    """Made when the job begins; `end` publishes the last message."""

    def __init__(self, order: Order) -> None:
        self.order = order
        self._began_s = time.monotonic()
        self.stream = EventStream()
        self.on_exit: Callable[[], None] = lambda: None  # called when all is published
        self._handlers: dict[str, Handler] = {}
        self._server = JobConnectionServer(self._do, self._publisher)
        self.address = JobAddress(
            id=order.id,
            kind=order.kind,
            by=order.by,
            wall=order.wall,
            session=order.session_name,
            rig=order.rig,
            pid=os.getpid(),
            port=self._server.port,
            key=self._server.key,
        )
        self.stream.publish(self.address.message())
        write_address(Path(order.data), self.address)

    def on(self, what: str, handler: Handler) -> None:
        """Do this when asked for `what`. A LabrigError is the asker's answer."""
        self._handlers[what] = handler

    def publish(self, message: Message) -> None:
        """Send a message to all panels."""
        self.stream.publish(message)

    def warn(self, text: str) -> None:
        """Publish a warning that is no part of the session; it is printed into the job's log."""
        with suppress(OSError):  # the disk of the log is full: pages are told all the same
            print(text, file=sys.stderr, flush=True)  # noqa: T201 - into job.log
        self.publish({"type": "warning", "time_s": None, "text": text, "log": text})

    def step(self, text: str) -> None:
        """Publish what is done next before the job is under way."""
        since_s = round(time.monotonic() - self._began_s, 3)
        self.publish({"type": "step", "text": text, "since_s": since_s})

    def end(self, code: int, text: str) -> None:
        """Publish and write down how it ended."""
        self.address = self.address.ended(code, text)
        write_address(Path(self.order.data), self.address)
        self.stream.publish(self.address.message())
        self._server.close(_FAREWELL_S)
        self.on_exit()

    def _do(self, asked: Header) -> Header:
        handler = self._handlers.get(str(asked.get("do")))
        if handler is None:
            return {"error": f"a {self.order.kind} job cannot {asked.get('do')}."}
        try:
            handler(asked)
        except LabrigError as error:
            return {"error": str(error)}
        except (KeyError, TypeError, ValueError) as error:
            return {"error": f"what was asked cannot be understood ({error!r})."}
        return {}

    def _publisher(self, role: str) -> EventStreamPublisher:
        return EventStreamPublisher(self.stream, _FOR_STOP if role == "stop" else None)


class EventStreamPublisher:
    """Send an event stream to one client; `only`: messages of these types and nothing else."""

    def __init__(self, stream: EventStream, only: frozenset[str] | None = None) -> None:
        self._stream = stream
        self._only = only
        self._news = threading.Event()
        self._closed = False
        self._box = Mailbox(self._news.set)

    def run(self, send_it: Callable[[bytes], None]) -> None:
        """See `connection.Publisher`."""
        self._stream.join(self._box)
        try:
            while True:
                closed = self._closed  # first, so that what came before is sent
                self._news.clear()
                while (mail := self._box.take()) is not None:
                    for packed in self._packed(mail):
                        send_it(packed)
                if (picture := self._box.take_picture()) is not None and self._only is None:
                    send_it(pack(*picture))
                if closed:
                    return
                self._news.wait()
        finally:
            self._stream.leave(self._box)

    def close(self) -> None:
        """See `connection.Publisher`."""
        self._closed = True
        self._news.set()

    def _packed(self, mail: Mail) -> list[bytes]:
        found: list[bytes] = []
        if mail.story is not None:
            found.append(pack({"type": "story", "messages": self._wanted(mail.story)}))
        found += [pack(message) for message in self._wanted(mail.messages)]
        if self._only is None:
            found += [pack(message) for message in mail.newest]
            if mail.strip is not None:
                found.append(mail.strip.packed())
        return found

    def _wanted(self, messages: list[Message]) -> list[Message]:
        return [m for m in messages if self._only is None or m["type"] in self._only]
