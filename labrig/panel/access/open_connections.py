"""Connections that have shown no credential: few, not for long, and never in the way of others."""

from __future__ import annotations

import sys
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

HEAD_S = 3.0  # from the connection to the end of its first request's head
MOST_UNIDENTIFIED = 256  # together; far more than browsers open before they have said who they are
LISTEN_BACKLOG = 1024  # the system may allow less: 128 to 4096 on Linux, about 200 on Windows
_DESCRIPTORS = 4096  # open files and sockets of one process

Connection = TypeVar("Connection", bound=Hashable)


class UnidentifiedConnections(Generic[Connection]):
    """In the order in which they came. One thread uses it: that of the event loop."""

    def __init__(self, close: Callable[[Connection], None], most: int = MOST_UNIDENTIFIED) -> None:
        """`close` is called with a connection that must make room for a new one."""
        self._close = close
        self._most = most
        self._open: dict[Connection, None] = {}

    def add(self, connection: Connection) -> None:
        """Add a new connection; where there are too many, close the one that came first."""
        self._open[connection] = None
        while len(self._open) > self._most:
            oldest = next(iter(self._open))
            del self._open[oldest]
            self._close(oldest)

    def discard(self, connection: Connection) -> None:
        """Forget a connection: it has shown a credential, or it is closed."""
        self._open.pop(connection, None)

    def __len__(self) -> int:
        """How many there are."""
        return len(self._open)


def raise_descriptor_limit() -> None:
    """Let this process open as many sockets as it may; Windows has no limit that matters here."""
    if sys.platform != "win32":
        import resource

        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        wanted = _DESCRIPTORS if hard == resource.RLIM_INFINITY else min(_DESCRIPTORS, hard)
        if soft != resource.RLIM_INFINITY and soft < wanted:
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
