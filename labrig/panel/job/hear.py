"""What the panel says to a job's process, heard from its beginning on."""

from __future__ import annotations

import os
import queue
import sys
import threading

Lines = queue.SimpleQueue[str]  # the rig, then the order
COUNT = 2


def heard() -> Lines:
    """Return the lines of standard input as they come.

    Where the panel goes before it has given an order, this process ends, whatever it is loading.
    """
    lines: Lines = queue.SimpleQueue()
    threading.Thread(target=_hear, args=(lines,), name="job-order", daemon=True).start()
    return lines


def _hear(lines: Lines) -> None:
    for _ in range(COUNT):
        line = sys.stdin.readline()
        if not line:
            os._exit(0)
        lines.put(line)
