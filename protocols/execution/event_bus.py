"""Hands events to subscribers: those the session depends on, and those that only watch."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable

from protocols.execution.events import Event, Warned

Subscriber = Callable[[Event], None]

WATCHER_QUEUE = 200  # events; a reading holds a frame, so this is also a limit of memory


class SubscriberError(Exception):
    """A subscriber that the session depends on has failed; the text says which and why."""


class EventBus:
    """Critical subscribers are called in order, and an exception of theirs reaches the emitter.

    Watchers can neither hold back nor break a run. With `threaded` (the real clock) each has a
    bounded queue and a thread of its own, and events that do not fit are left out for it. Without
    (a virtual clock) they are called at once, so that a simulated session is the same each time.
    A watcher's first failure, and the first event left out for it, are told as Warned.
    """

    def __init__(self, *, threaded: bool = True) -> None:
        self._critical: list[tuple[str, Subscriber]] = []
        self._watchers: list[_Watcher] = []
        self._threaded = threaded
        # Two threads may emit: the scheduler's, and one that marks a reading.
        self._lock = threading.RLock()

    def add_critical(self, name: str, subscriber: Subscriber) -> None:
        """The session stops safely when this subscriber raises: the session's writer."""
        self._critical.append((name, subscriber))

    def add_watcher(self, name: str, subscriber: Subscriber) -> None:
        """Something that shows the session: panel, progress bar."""
        make = _ThreadedWatcher if self._threaded else _Watcher
        self._watchers.append(make(name, subscriber))

    def emit(self, event: Event) -> None:
        """Hand an event to everybody, then raise SubscriberError if a critical one failed."""
        with self._lock:
            failed = self._hand_over(event)
            for watcher in self._watchers:
                if trouble := watcher.new_trouble():
                    failed = self._hand_over(Warned(event.time_s, trouble)) or failed
        if failed is not None:
            raise failed

    def close(self, timeout_s: float = 2.0) -> None:
        """Let the watchers finish what they have; one that is stuck is left behind."""
        for watcher in self._watchers:
            watcher.close(timeout_s)

    def _hand_over(self, event: Event) -> SubscriberError | None:
        """Everybody gets the event, whoever fails; the first failure is returned."""
        failed: SubscriberError | None = None
        for name, subscriber in self._critical:
            try:
                subscriber(event)
            except Exception as error:  # noqa: BLE001 - whatever it is, the others get the event
                failed = failed or _named(name, error)
        for watcher in self._watchers:
            watcher.hand_over(event)
        return failed


def _named(name: str, error: Exception) -> SubscriberError:
    wrapped = SubscriberError(f"{name}: {error or type(error).__name__}")
    wrapped.__cause__ = error
    return wrapped


class _Watcher:
    """Called at once; its exceptions are kept for `new_trouble`."""

    def __init__(self, name: str, subscriber: Subscriber) -> None:
        self.name = name
        self._subscriber = subscriber
        self._trouble: dict[str, str] = {}
        self._told: set[str] = set()

    def hand_over(self, event: Event) -> None:
        """Give it the event; never raises."""
        try:
            self._subscriber(event)
        except Exception as error:  # noqa: BLE001 - a watcher must not break a run
            text = f"{self.name} failed and may show too little: {type(error).__name__}: {error}"
            self._trouble.setdefault("failed", text)

    def new_trouble(self) -> str:
        """A sentence on something that has not been told yet, or nothing."""
        for kind, text in list(self._trouble.items()):
            if kind not in self._told:
                self._told.add(kind)
                return text
        return ""

    def close(self, timeout_s: float) -> None:
        """Nothing to do: everything was handed over at once."""


class _ThreadedWatcher(_Watcher):
    """Called in a thread of its own."""

    def __init__(self, name: str, subscriber: Subscriber) -> None:
        super().__init__(name, subscriber)
        self._events: queue.Queue[Event | None] = queue.Queue(WATCHER_QUEUE)
        self._thread = threading.Thread(target=self._work, name=f"labrig-{name}", daemon=True)
        self._thread.start()

    def hand_over(self, event: Event) -> None:
        try:
            self._events.put_nowait(event)
        except queue.Full:
            text = f"{self.name} is too slow and is not shown everything"
            self._trouble.setdefault("slow", text)

    def close(self, timeout_s: float) -> None:
        try:
            self._events.put(None, timeout=timeout_s)
        except queue.Full:
            return
        self._thread.join(timeout_s)

    def _work(self) -> None:
        while (event := self._events.get()) is not None:
            super().hand_over(event)
