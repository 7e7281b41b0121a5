"""Real-time priorities: of the thread that writes edges alone, where the system permits them."""

from __future__ import annotations

import os
import sys
import threading

import pytest

from drivers.real_time import EDGES, punctual

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="has no such priorities")


def policy() -> int:
    """Of this thread, without the flag that threads it starts do not inherit it."""
    return os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK


def in_a_thread(work):
    """What `work` returns in a thread of its own, whose priority is nobody else's."""
    found = []
    thread = threading.Thread(target=lambda: found.append(work()))
    thread.start()
    thread.join()
    return found[0]


def test_inside_the_block_the_thread_alone_has_it():
    def work():
        with punctual(EDGES) as has_it:
            inside = policy(), os.sched_getparam(0).sched_priority, in_a_thread(policy)
        return has_it, inside, policy()

    has_it, inside, after = in_a_thread(work)
    if not has_it:
        pytest.skip("this user may not have real-time priorities (ulimit -r), or has one core")
    assert inside == (os.SCHED_FIFO, EDGES, os.SCHED_OTHER)
    assert after == os.SCHED_OTHER


def test_on_a_single_core_no_thread_comes_before_the_guard(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _pid: {0})
    with punctual(EDGES) as has_it:
        assert not has_it
        assert policy() == os.SCHED_OTHER


def test_who_may_not_have_it_works_without(monkeypatch):
    def refuse(*_arguments):
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    with punctual(EDGES) as has_it:
        assert not has_it
        assert policy() == os.SCHED_OTHER
