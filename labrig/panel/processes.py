"""What is the same for every process that the panel starts, and for ending it with its children."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import TypedDict

_ROOT = Path(__file__).resolve().parents[2]
LOWER_BY = 10  # nice steps of what must not slow a run down
LOWEST_PRIORITY = 19
CAN_STEP_BACK = sys.platform == "linux"  # elsewhere a low priority is for good


class Detached(TypedDict):
    """Options of `subprocess.Popen`."""

    start_new_session: bool
    creationflags: int


def module_environment() -> dict[str, str]:
    """Return an environment in which a process finds our packages, wherever it is started."""
    path = os.pathsep.join(filter(None, [str(_ROOT), os.environ.get("PYTHONPATH")]))
    # PYTHONSAFEPATH: a module of that name in the folder it is started in hides none of ours.
    return {**os.environ, "PYTHONPATH": path, "PYTHONSAFEPATH": "1"}


def detached() -> Detached:
    """Return a process that neither Ctrl-C at the panel's terminal nor the panel's end reaches."""
    flags = 0
    if sys.platform == "win32":
        flags = subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW
    return {"start_new_session": sys.platform != "win32", "creationflags": flags}


def in_background() -> Detached:
    """Return the same for a process that computes: on Windows its priority is low from the start.

    Elsewhere `lower_priority` does that when it is needed.
    """
    options = detached()
    if sys.platform == "win32":
        options["creationflags"] |= subprocess.BELOW_NORMAL_PRIORITY_CLASS
    return options


def lower_priority(leader: int) -> None:
    """Lower the priority of a detached process and all its children; it cannot be raised again."""
    if sys.platform != "win32":
        with suppress(OSError):  # it has just ended
            now = os.getpriority(os.PRIO_PGRP, leader)
            lower = min(LOWEST_PRIORITY, now + LOWER_BY)
            os.setpriority(os.PRIO_PGRP, leader, lower)
            # Where Linux groups processes by session, their own priority counts within it only.
            Path(f"/proc/{leader}/autogroup").write_text(str(lower), encoding="ascii")


def step_back(pid: int) -> None:
    """Let a detached process compute only when nobody else does, until `step_forward`."""
    if sys.platform == "linux":
        _schedule(pid, os.SCHED_IDLE, LOWEST_PRIORITY)


def step_forward(pid: int) -> None:
    """Let a process compute as any other again."""
    if sys.platform == "linux":
        _schedule(pid, os.SCHED_OTHER, 0)


if sys.platform == "linux":

    def _schedule(pid: int, policy: int, session_priority: int) -> None:
        with suppress(OSError):  # it has just ended, or sessions have no priority here
            Path(f"/proc/{pid}/autogroup").write_text(str(session_priority), encoding="ascii")
        with suppress(OSError):
            for thread in Path(f"/proc/{pid}/task").iterdir():
                os.sched_setscheduler(int(thread.name), policy, os.sched_param(0))


def end_with_children(leader: int) -> None:
    """End a detached process and all its children at once; nothing happens if it has ended."""
    if sys.platform == "win32":
        command = ["taskkill", "/F", "/T", "/PID", str(leader)]
        subprocess.run(command, capture_output=True, check=False)
    else:
        with suppress(OSError):
            os.killpg(leader, signal.SIGKILL)


def be_ended_first() -> None:
    """Have the system end this process and its children, not a run, when memory is short."""
    with suppress(OSError):  # Linux only
        Path("/proc/self/oom_score_adj").write_text("1000", encoding="ascii")
