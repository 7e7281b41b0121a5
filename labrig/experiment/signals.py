"""Turn Ctrl-C and other signals into requests to stop; instrument calls are never interrupted."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from protocols.execution.stop import StopLevel, StopRequest

# SIGHUP is a closed terminal, SIGBREAK the same on Windows; each exists on one kind of system.
_NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
DEAF_S = 3.0  # who has not obeyed a request to stop at once by then waits for a device


@contextmanager
def stop_signals(on_stop: Callable[[str, int], None]) -> Iterator[None]:
    """While inside, call `on_stop(signal's name, how many came so far)` for each stop signal.

    The handler runs between two steps of the main thread, so it must only set a flag (or raise,
    where the main thread does nothing but wait for a person).
    """
    count = 0

    def handle(number: int, _frame: FrameType | None) -> None:
        nonlocal count
        count += 1
        on_stop(signal.Signals(number).name, count)

    previous: dict[int, Any] = {number: signal.signal(number, handle) for number in _numbers()}
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


class SignalledStop:
    """Asks for a stop at each signal: Ctrl-C once after the pulse, all others at once.

    A device whose code does not return, where no voltage is on and so no guard acts, would keep the
    program for ever. So a signal interrupts it, once, where a stop at once is not obeyed for
    `DEAF_S`. Not during the safe shutdown, which has limits of its own.
    """

    def __init__(self, stop: StopRequest, now: Callable[[], float] = time.monotonic) -> None:
        self._stop = stop
        self._now = now  # s
        self._urgent_s: float | None = None  # since when a stop at once is asked for
        self._has_interrupted = False

    def __call__(self, name: str, count: int) -> None:
        """Take a signal. Raises KeyboardInterrupt."""
        level = StopLevel.AFTER_PULSE if count == 1 and name == "SIGINT" else StopLevel.NOW
        self._stop.request(level, f"stopped by {'Ctrl-C' if name == 'SIGINT' else name}")
        now = self._now()
        if self._urgent_s is None and level is StopLevel.NOW:
            self._urgent_s = now
        deaf = self._urgent_s is not None and now - self._urgent_s >= DEAF_S
        if deaf and not (self._has_interrupted or self._stop.is_obeyed):
            self._has_interrupted = True
            raise KeyboardInterrupt


def ignore_stop_signals() -> None:
    """Ignore them until the process ends: its exit code is settled, and must not be lost."""
    for number in _numbers():
        signal.signal(number, signal.SIG_IGN)


def _numbers() -> list[signal.Signals]:
    return [getattr(signal, name) for name in _NAMES if hasattr(signal, name)]
