"""The receive buffers of sockets that a library has opened.

Aravis makes its socket's buffer larger only once the first packet has come, and the first frame may
be lost by then where the computer is busy.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_OPEN_FILES = Path("/proc/self/fd")  # Linux; elsewhere nothing is done


@contextmanager
def enlarged(size: int) -> Iterator[None]:
    """Give each UDP socket that is opened inside the block a buffer of so many bytes."""
    before = _sockets()
    yield
    for number, _ in _sockets() - before:
        with suppress(OSError):  # it is closed again
            _enlarge(number, size)


def _sockets() -> set[tuple[int, str]]:
    """Return the open sockets, each with its name: a number may be another file's meanwhile."""
    found = set()
    with suppress(OSError):
        for path in _OPEN_FILES.iterdir():
            with suppress(OSError):  # the folder's own number is closed by now
                found.add((int(path.name), str(path.readlink())))
    return {each for each in found if each[1].startswith("socket:")}


def _enlarge(number: int, size: int) -> None:
    with socket.socket(fileno=os.dup(number)) as found:
        if found.type == socket.SOCK_DGRAM:
            found.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, size)
