"""Processes that share the work of another end with it, whatever has ended it."""

from __future__ import annotations

import os
import select
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
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


def end_with_input() -> None:
    """End this process as soon as nobody can write to its standard input, read or not.

    For processes whose input is their parent's pipe, while they load what takes long. Windows has
    no such notice: there a process ends when it reads.
    """
    if sys.platform != "win32":
        threading.Thread(target=_until_hang_up, name="input-watch", daemon=True).start()


@contextmanager
def interrupts_blocked() -> Iterator[None]:
    """Let processes that are started now by this thread never see Ctrl-C, from their first moment.

    It reaches all processes of a terminal. One that still loads would answer with a traceback; all
    end with their parent, who decides. Windows has no signal masks: there it is as before.
    """
    if sys.platform == "win32":
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # would let signals through when it starts
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


if sys.platform != "win32":

    def _until_hang_up() -> None:
        notice = select.poll()
        notice.register(0, 0)  # a hang-up is always told
        notice.poll()
        os._exit(1)


def _wait(sentinel: int) -> None:
    connection.wait([sentinel])
    os._exit(1)
