"""Threads that the system serves before all that computes: those that write edges, or watch.

Linux, where the user may have real-time priorities (`ulimit -r` is not 0). Elsewhere nothing
changes.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

EDGES, WATCH = 10, 20  # of 1 to 99


@contextmanager
def punctual(priority: int) -> Iterator[bool]:
    """Give this thread alone, and not those it starts, a real-time priority inside the block.

    Not where there is one core only: there a loop that never waits would starve the guard, which
    takes its own starvation for a busy computer's and is patient.
    """
    has_it = _cores() > 1 and _set("SCHED_FIFO", priority)
    try:
        yield has_it
    finally:
        if has_it:
            _set("SCHED_OTHER", 0)


def _cores() -> int:
    affinity = getattr(os, "sched_getaffinity", None)  # Linux has it
    return len(affinity(0)) if affinity is not None else 1


def _set(policy: str, priority: int) -> bool:
    if sys.platform == "linux":
        # That threads do not inherit it may be set by anybody, but not taken back.
        flag = os.SCHED_RESET_ON_FORK
        with suppress(OSError):  # not permitted
            os.sched_setscheduler(0, getattr(os, policy) | flag, os.sched_param(priority))
            return True
    return False
