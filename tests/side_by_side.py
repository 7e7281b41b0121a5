"""Which tests run beside which, where pytest-xdist has several workers.

Those that watch other processes on the real clock wait most of the time, and are the steadier the
sooner they get the processor; all others compute. So one worker begins with those that watch, and
the others, which step back for it, compute meanwhile.
"""

from __future__ import annotations

import os

import pytest

WATCHING = (
    "tests/drivers/test_guard_process.py",
    "tests/drivers/test_time_outs.py",
    "tests/end_to_end/test_guard_of_a_run.py",
    "tests/end_to_end/test_run_real_clock.py",
    "tests/labrig/panel/test_attacks.py",
    "tests/labrig/panel/test_forms.py",
    "tests/labrig/panel/test_panel_",
    "tests/labrig/panel/test_replay.py",
    "tests/labrig/panel/test_sessions.py",
    "tests/labrig/session/test_recover.py",
    "tests/panel_browser/",
    "tests/sim_hardware/test_serve.py",
)
# Begun first, or one worker is at them when the others are done.
LONGEST = ("tests/end_to_end/test_demo.py", "tests/end_to_end/test_closed_loop")
STEP_BACK = 5  # as `nice`
Items = list[pytest.Item]


def watches(item: pytest.Item) -> bool:
    """Whether a test watches other processes on the real clock."""
    return item.nodeid.startswith(WATCHING)


def in_parts(items: Items, workers: int) -> Items:
    """In the order in which `--dist worksteal` hands out equal parts, one to each worker.

    The first part begins with all that watch, the others with what takes long; what is quick comes
    last, and is what a worker that has nothing more to do takes over.
    """
    if workers < 2:
        return items
    parts: list[Items] = [[item for item in items if watches(item)]]
    long = [[item for item in items if item.nodeid.startswith(name)] for name in LONGEST]
    rest = [item for item in items if not item.nodeid.startswith((*WATCHING, *LONGEST))]
    slow = [item for item in rest if item.get_closest_marker("slow")]
    quick = [item for item in rest if not item.get_closest_marker("slow")]
    for k in range(workers - 1):
        first = [item for group in long[k :: workers - 1] for item in group]
        parts.append(first + _share(slow, k, workers - 1))
    for k, part in enumerate(parts):
        lacking = max(0, len(_share(items, k, workers)) - len(part))
        part += quick[:lacking]
        del quick[:lacking]
    return [item for part in parts for item in part] + quick


def _share(items: Items, k: int, of: int) -> Items:
    """The k-th of so many equal parts."""
    return items[k * len(items) // of : (k + 1) * len(items) // of]


def step_back() -> None:
    """Leave the processor to the worker that watches, where a system has such a thing."""
    if hasattr(os, "nice"):
        os.nice(STEP_BACK)
