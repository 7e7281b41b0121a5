"""The queue between the experiment and the disk, which notices a disk that has stopped.

It lives in real time, whatever clock the session runs on: a disk is real.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from typing import Generic, TypeVar

Item = TypeVar("Item")


class StalledError(Exception):
    """The consumer has been busy with one item, or the queue full, for too long."""


class WriteQueue(Generic[Item]):
    """A queue bounded in bytes, for one producer side and one consumer."""

    def __init__(self, limit_bytes: int, patience_s: float) -> None:
        self._limit = limit_bytes
        self._patience_s = patience_s
        self._items: deque[tuple[Item, int]] = deque()
        self._bytes = 0
        self._closed = False
        self._taken_s: float | None = None  # when the consumer took what it is busy with
        self._changed = threading.Condition()

    def put(self, item: Item, size: int) -> None:
        """Queue an item; waits for room only while the queue is full. Raises StalledError."""
        deadline = time.monotonic() + self._patience_s
        with self._changed:
            self._raise_when_stalled()
            while self._items and self._bytes + size > self._limit:
                left = deadline - time.monotonic()
                if left <= 0 or self._closed:
                    raise StalledError(f"the queue has been full for {self._patience_s:g} s")
                self._changed.wait(left)
            self._items.append((item, size))
            self._bytes += size
            self._changed.notify_all()

    def take(self, timeout_s: float) -> Item | None:
        """Return the next item; None after `timeout_s` without one, or when closed and empty."""
        with self._changed:
            self._taken_s = None
            if not self._items and not self._closed:
                self._changed.wait(timeout_s)
            if not self._items:
                return None
            item, size = self._items.popleft()
            self._bytes -= size
            self._taken_s = time.monotonic()
            self._changed.notify_all()
            return item

    def close(self) -> None:
        """Nothing more will be put; what is queued can still be taken."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def drop(self) -> None:
        """Close, and forget what is queued: nobody will take it."""
        with self._changed:
            self._items.clear()
            self._bytes = 0
            self._taken_s = None
            self._closed = True
            self._changed.notify_all()

    @property
    def empty(self) -> bool:
        """Whether nothing is queued at the moment."""
        return not self._items

    @property
    def closed(self) -> bool:
        """Whether nothing more can be put."""
        return self._closed

    @property
    def ended(self) -> bool:
        """Whether it is closed and all was taken."""
        return self._closed and not self._items

    def _raise_when_stalled(self) -> None:
        taken = self._taken_s
        if taken is not None and time.monotonic() - taken > self._patience_s:
            raise StalledError(f"the disk has not answered for {time.monotonic() - taken:.1f} s")
