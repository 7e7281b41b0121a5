"""A job's process. It hears the panel before it loads anything: the panel may go meanwhile."""

from __future__ import annotations

import os
import sys
import threading
from queue import SimpleQueue

from labrig.garbage import look_for_garbage_seldom

LINES = 2  # the rig, then the order


def main() -> int:
    """Do what is ordered."""
    look_for_garbage_seldom()
    lines: SimpleQueue[str] = SimpleQueue()
    threading.Thread(target=_hear, args=(lines,), name="job-order", daemon=True).start()
    from labrig.panel.job.perform import perform

    return perform(lines)


def _hear(lines: SimpleQueue[str]) -> None:
    """Hand over the lines as they come. Without an order the panel has gone, and this ends."""
    for _ in range(LINES):
        line = sys.stdin.readline()
        if not line:
            os._exit(0)
        lines.put(line)


if __name__ == "__main__":
    ended = main()
    if "labrig.session.recording.disk" in sys.modules:
        sys.modules["labrig.session.recording.disk"].end_before_the_library_does(ended)
    sys.exit(ended)
