"""Events of a task: registered before it starts, sent on streams while it runs."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator
from dataclasses import dataclass

from sim_hardware.ni.rpc import Message


class Stream:
    """Events for one listener, in their order. Ends when it is closed from either side."""

    # How long `send_and_wait` waits for a listener that has stopped listening.
    LISTENER_TIMEOUT_S = 30.0

    def __init__(self) -> None:
        self._events: queue.SimpleQueue[Message | None] = queue.SimpleQueue()
        self._handled = threading.Semaphore(0)
        self._closed = threading.Event()

    @property
    def closed(self) -> bool:
        """No more events will come."""
        return self._closed.is_set()

    def send(self, event: Message) -> None:
        """Queue an event; lost when the stream is closed."""
        self._events.put(event)

    def send_and_wait(self, event: Message) -> None:
        """Send, and return when the listener asks for the next one (or has gone)."""
        self.send(event)
        self._handled.acquire(timeout=self.LISTENER_TIMEOUT_S)

    def drop_pending(self) -> None:
        """Remove the events that have not been sent yet."""
        try:
            while True:
                if self._events.get_nowait() is None:
                    self._events.put(None)  # the end stays
                    return
        except queue.Empty:
            return

    def close(self) -> None:
        """End the stream. May be called twice."""
        self._closed.set()
        self._events.put(None)
        self._handled.release()

    def __iter__(self) -> Iterator[Message]:
        while (event := self._events.get()) is not None:
            yield event
            self._handled.release()


@dataclass(frozen=True)
class EveryNSamples:
    """A registration for an event after every `samples` samples."""

    samples: int
    stream: Stream
    kind: int = 1  # nidaqmx.constants.EveryNSamplesEventType


@dataclass
class TaskEvents:
    """The registrations of one task."""

    every_n: EveryNSamples | None = None
    done: Stream | None = None

    def streams(self) -> list[Stream]:
        """All that listen."""
        found = [self.every_n.stream] if self.every_n else []
        return found + ([self.done] if self.done else [])

    def close(self) -> None:
        """End every stream and forget it."""
        for stream in self.streams():
            stream.close()
        self.every_n = self.done = None
