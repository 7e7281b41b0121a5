"""Processes that share the work of another end with it, whatever has ended it."""

from __future__ import annotations

import os
import threading
from multiprocessing import connection, parent_process


def end_with_parent() -> None:
    """End this process as soon as the one that started it by `multiprocessing` is gone.

    Nobody tells a worker of a pool that its parent was killed: it would wait for ever. The system
    closes what both share, on Windows as elsewhere. Called once, by the process itself.
    """
    parent = parent_process()
    if parent is None:  # nobody has started it
        return
    ends = threading.Thread(target=_wait, args=(parent.sentinel,), name="parent-watch", daemon=True)
    ends.start()


def _wait(sentinel: int) -> None:
    connection.wait([sentinel])
    os._exit(1)
