"""Time, and threads that live in it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Protocol


class ThreadHandle(Protocol):
    """A thread started by a clock."""

    def join(self, timeout: float | None = None) -> bool:
        """Wait for the thread's end, at most `timeout` seconds; return whether it has ended."""


class Clock(Protocol):
    """Time, and threads that live in it. The real clock is `RealClock`; the simulator has another.

    Everything that waits does it here, so that a simulated session need not wait.
    """

    def now(self) -> float:
        """Monotonic time in s, from an arbitrary origin."""

    def sleep_until(self, when: float) -> None:
        """Return when `now() >= when`; at once when that has passed."""

    def start_thread(self, target: Callable[[], None], name: str) -> ThreadHandle:
        """Run `target` beside the caller. It may wait only by this clock or by its own device."""


class _RealThread:
    def __init__(self, target: Callable[[], None], name: str) -> None:
        self._thread = threading.Thread(target=target, name=name, daemon=True)
        self._thread.start()

    def join(self, timeout: float | None = None) -> bool:
        self._thread.join(timeout)
        return not self._thread.is_alive()


class RealClock:
    """The computer's monotonic clock."""

    # The operating system wakes a sleeper late by up to a fraction of a millisecond; the last bit
    # is spent in a loop, so that an edge is as punctual as the computer can make it.
    SPIN_S = 3e-4

    def now(self) -> float:
        """See `Clock.now`."""
        return time.perf_counter()

    def sleep_until(self, when: float) -> None:
        """See `Clock.sleep_until`."""
        left = when - time.perf_counter()
        if left > self.SPIN_S:
            time.sleep(left - self.SPIN_S)  # noqa: TID251 - this is the one place that may sleep
        while time.perf_counter() < when:
            pass

    def start_thread(self, target: Callable[[], None], name: str) -> ThreadHandle:
        """See `Clock.start_thread`."""
        return _RealThread(target, name)
