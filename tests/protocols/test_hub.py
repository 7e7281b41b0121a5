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
    hub, heard = EventBus(threaded=False), []
    hub.add_required("the session file", raising)
    hub.add_required("another", heard.append)
    hub.add_best_effort("panel", heard.append)
    with pytest.raises(SubscriberError, match="the session file: disk full"):
        hub.emit(EVENT)
    assert heard == [EVENT, EVENT]


@pytest.mark.parametrize("threaded", [False, True])
def test_a_watchers_failure_is_told_once_as_a_warning_and_breaks_nothing(threaded):
    hub, heard, failed = EventBus(threaded=threaded), [], threading.Semaphore(0)

    def fail(_):
        failed.release()
        raise ValueError("no such page")

    hub.add_required("file", heard.append)
    hub.add_best_effort("panel", fail)
    hub.emit(EVENT)
    assert failed.acquire(timeout=5)
    for _ in range(100):  # the thread's exception may take a moment to be noted
        hub.emit(EVENT)
        if any(isinstance(event, Warned) for event in heard):
            break
        threading.Event().wait(0.01)
    for _ in range(3):
        hub.emit(EVENT)
    hub.close()
    warnings = [event for event in heard if isinstance(event, Warned)]
    assert [w.text for w in warnings] == [
        "panel failed and may show too little: ValueError: no such page"
    ]


def test_a_watcher_that_hangs_holds_nobody_back_and_is_reported_once():
    hub, heard, release = EventBus(), [], threading.Event()
    hub.add_required("file", heard.append)
    hub.add_best_effort("panel", lambda _: release.wait(30))
    for _ in range(QUEUE_EVENTS + 50):
        hub.emit(EVENT)
    warnings = [event for event in heard if isinstance(event, Warned)]
    assert [w.text for w in warnings] == ["panel is too slow and is not shown everything"]
    assert len(heard) == QUEUE_EVENTS + 51
    hub.close(timeout_s=0.01)
    release.set()


def test_closing_lets_a_watcher_finish():
    hub, heard = EventBus(), []
    hub.add_best_effort("progress", heard.append)
    for _ in range(100):
        hub.emit(EVENT)
    hub.close()
    assert len(heard) == 100
