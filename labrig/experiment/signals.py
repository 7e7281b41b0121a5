"""Turn Ctrl-C and other signals into requests to stop."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

# SIGHUP is a closed terminal, SIGBREAK the same on Windows; each exists on one kind of system.
_NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")


@contextmanager
def stop_signals(on_stop: Callable[[str, int], None]) -> Iterator[None]:
    """While inside, call `on_stop(signal's name, how many came so far)` for each stop signal.

    The handler runs between two steps of the main thread, so it should only set a flag. It may
    raise where the main thread waits for a person, or for a device that does not answer
    (`SignalledStop`).
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


def ignore_stop_signals() -> None:
    """Ignore them until the process ends: its exit code is settled, and must not be lost."""
    for number in _numbers():
        signal.signal(number, signal.SIG_IGN)


def _numbers() -> list[signal.Signals]:
    return [getattr(signal, name) for name in _NAMES if hasattr(signal, name)]
