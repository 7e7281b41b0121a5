"""Hand events to subscribers: required ones, and those that are served as well as possible."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable

from protocols.execution.events import Event, Warned

Subscriber = Callable[[Event], None]

QUEUE_EVENTS = 200  # events; a reading holds a frame, so this is also a limit of memory


class SubscriberError(Exception):
    """A subscriber that the session depends on has failed; the text says which and why."""


class EventBus:
    """Required subscribers are called in order; their exceptions reach the emitter.

    Best-effort subscribers can neither delay nor break a run. With `threaded` (the real clock) each
    has a bounded queue and a thread of its own, and events that do not fit are left out for it.
    Without (a virtual clock) they are called at once, so that a simulated session is the same each
    time.
    Their first failure, and the first event left out for one, are emitted as Warned.
    """

    def __init__(self, *, threaded: bool = True) -> None:
        self._required: list[tuple[str, Subscriber]] = []
        self._best_effort: list[_Delivery] = []
        self._threaded = threaded
        # Two threads may emit: the scheduler's, and one that marks a reading.
        self._lock = threading.RLock()

    def add_required(self, name: str, subscriber: Subscriber) -> None:
        """Add one whose exception stops the session safely: the session's writer."""
        self._required.append((name, subscriber))

    def add_best_effort(self, name: str, subscriber: Subscriber) -> None:
        """Add one that only shows the session: panel, progress bar."""
        make = _ThreadedDelivery if self._threaded else _Delivery
        self._best_effort.append(make(name, subscriber))

    def emit(self, event: Event) -> None:
        """Hand an event to everybody, then raise SubscriberError if a required one failed."""
        with self._lock:
            failed = self._hand_over(event)
            for delivery in self._best_effort:
                if trouble := delivery.new_trouble():
                    failed = self._hand_over(Warned(event.time_s, trouble)) or failed
        if failed is not None:
            raise failed

    def close(self, timeout_s: float = 2.0) -> None:
        """Let best-effort subscribers finish their queues; one that hangs is left behind."""
        for delivery in self._best_effort:
            delivery.close(timeout_s)

    def _hand_over(self, event: Event) -> SubscriberError | None:
        """Everybody gets the event, whoever fails; the first failure is returned."""
        failed: SubscriberError | None = None
        for name, subscriber in self._required:
            try:
                subscriber(event)
            except Exception as error:  # noqa: BLE001 - whatever it is, the others get the event
                failed = failed or _named(name, error)
        for delivery in self._best_effort:
            delivery.hand_over(event)
        return failed


def _named(name: str, error: Exception) -> SubscriberError:
    wrapped = SubscriberError(f"{name}: {error or type(error).__name__}")
    wrapped.__cause__ = error
    return wrapped


class _Delivery:
    """Call a best-effort subscriber at once; its exceptions are kept for `new_trouble`."""

    def __init__(self, name: str, subscriber: Subscriber) -> None:
        self.name = name
        self._subscriber = subscriber
        self._trouble: dict[str, str] = {}
        self._reported: set[str] = set()

    def hand_over(self, event: Event) -> None:
        """Give it the event; never raises."""
        try:
            self._subscriber(event)
        except (Exception, SystemExit) as error:  # noqa: BLE001 - it must not break a run
            text = f"{self.name} failed and may show too little: {type(error).__name__}: {error}"
            self._trouble.setdefault("failed", text)

    def new_trouble(self) -> str:
        """Return a sentence on something that was not reported yet, or nothing."""
        for kind, text in list(self._trouble.items()):
            if kind not in self._reported:
                self._reported.add(kind)
                return text
        return ""

    def close(self, timeout_s: float) -> None:
        """Nothing to do: everything was handed over at once."""


class _ThreadedDelivery(_Delivery):
    """Call it in a thread of its own."""

    def __init__(self, name: str, subscriber: Subscriber) -> None:
        super().__init__(name, subscriber)
        self._events: queue.Queue[Event | None] = queue.Queue(QUEUE_EVENTS)
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
