"""Who hears of what, and what they can break."""

import threading

import pytest

from protocols import EventBus, SubscriberError
from protocols.execution.event_bus import QUEUE_EVENTS
from protocols.execution.events import SessionStarted, Warned

EVENT = SessionStarted(1.0, "")


def raising(_):
    raise OSError("disk full")


def test_everybody_gets_the_event_when_a_critical_subscriber_fails_and_the_emitter_is_told():
    event_bus, heard = EventBus(threaded=False), []
    event_bus.add_required("the session file", raising)
    event_bus.add_required("another", heard.append)
    event_bus.add_best_effort("panel", heard.append)
    with pytest.raises(SubscriberError, match="the session file: disk full"):
        event_bus.emit(EVENT)
    assert heard == [EVENT, EVENT]


@pytest.mark.parametrize("threaded", [False, True])
def test_a_watchers_failure_is_told_once_as_a_warning_and_breaks_nothing(threaded):
    event_bus, heard, failed = EventBus(threaded=threaded), [], threading.Semaphore(0)

    def fail(_):
        failed.release()
        raise ValueError("no such page")

    event_bus.add_required("file", heard.append)
    event_bus.add_best_effort("panel", fail)
    event_bus.emit(EVENT)
    assert failed.acquire(timeout=5)
    for _ in range(100):  # the thread's exception may take a moment to be noted
        event_bus.emit(EVENT)
        if any(isinstance(event, Warned) for event in heard):
            break
        threading.Event().wait(0.01)
    for _ in range(3):
        event_bus.emit(EVENT)
    event_bus.close()
    warnings = [event for event in heard if isinstance(event, Warned)]
    assert [w.text for w in warnings] == [
        "panel failed and may show too little: ValueError: no such page"
    ]


def test_a_watcher_that_hangs_holds_nobody_back_and_is_reported_once():
    event_bus, heard, release = EventBus(), [], threading.Event()
    event_bus.add_required("file", heard.append)
    event_bus.add_best_effort("panel", lambda _: release.wait(30))
    for _ in range(QUEUE_EVENTS + 50):
        event_bus.emit(EVENT)
    warnings = [event for event in heard if isinstance(event, Warned)]
    assert [w.text for w in warnings] == ["panel is too slow and is not shown everything"]
    assert len(heard) == QUEUE_EVENTS + 51
    event_bus.close(timeout_s=0.01)
    release.set()


def test_closing_lets_a_watcher_finish():
    event_bus, heard = EventBus(), []
    event_bus.add_best_effort("progress", heard.append)
    for _ in range(100):
        event_bus.emit(EVENT)
    event_bus.close()
    assert len(heard) == 100
