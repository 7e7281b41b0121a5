"""Which tests run beside which, where pytest-xdist has several workers.

Those that watch other processes on the real clock wait most of the time, and are the steadier the
sooner they get the processor; all others compute. So some workers begin with those that watch, and
the others, which step back for them, compute meanwhile.
"""

from __future__ import annotations

import os

import pytest

PROCESSES = (
    "tests/drivers/test_guard_process.py",
    "tests/drivers/test_time_outs.py",
    "tests/end_to_end/test_devices_recorded.py",
    "tests/end_to_end/test_force_meter.py",
    "tests/end_to_end/test_guard_of_a_run.py",
    "tests/end_to_end/test_parts_of_others.py",
    "tests/end_to_end/test_run_real_clock.py",
    "tests/labrig/panel/test_attacks.py",
    "tests/labrig/panel/test_forms.py",
    "tests/labrig/panel/test_page_notes.py",
    "tests/labrig/panel/test_panel_",
    "tests/labrig/panel/test_pause.py",
    "tests/labrig/panel/test_replay.py",
    "tests/labrig/panel/test_sessions.py",
    "tests/labrig/session/test_recover.py",
    "tests/sim_hardware/test_serve.py",
)
BROWSER = ("tests/panel_browser/",)  # as long as all the others that watch
WATCHING = (*PROCESSES, *BROWSER)
# Begun first, or one worker is at them when the others are done.
LONGEST = (
    "tests/panel_browser/test_with_the_mouse.py",
    "tests/end_to_end/test_demo.py",
    "tests/labrig/panel/test_analysis_in_the_panel.py",
    "tests/end_to_end/test_closed_loop",
    "tests/labrig/panel/test_live_fit.py",
)
# Of those that run alone: each worker takes the next file. The longest come first, so that both end
# together, and what has the narrowest limits, at the page, is beside what waits most.
ALONE = (
    "tests/soak/",
    "tests/end_to_end/test_guard_of_a_run.py",
    "tests/labrig/panel/",
    "tests/panel_browser/",
    "tests/end_to_end/",
    "tests/drivers/",
    "",
)
STEP_BACK = 5  # as `nice`
Items = list[pytest.Item]


def watches(item: pytest.Item) -> bool:
    """Whether a test watches other processes on the real clock."""
    return item.nodeid.startswith(WATCHING) or is_alone(item)


def is_alone(item: pytest.Item) -> bool:
    """Whether nothing that computes may run beside a test."""
    return item.get_closest_marker("alone") is not None


def in_turn(items: Items) -> Items:
    """Tests that all run alone in the order of their files, for `--dist loadfile`."""

    def turn(item: pytest.Item) -> int:
        return next(k for k, name in enumerate(ALONE) if item.nodeid.startswith(name))

    return sorted(items, key=turn)


def in_parts(items: Items, workers: int) -> Items:
    """In the order in which `--dist worksteal` hands out equal parts, one to each worker.

    Of four parts or more two begin with what watches, else one; the others begin with what takes
    long. What is quick comes last, and is what a worker that has nothing more to do takes over.
    """
    if workers < 2:
        return items
    kinds = (PROCESSES, BROWSER) if workers > 3 else (WATCHING,)
    items = sorted(items, key=lambda item: not item.nodeid.startswith(LONGEST))
    parts = [[item for item in items if item.nodeid.startswith(names)] for names in kinds]
    computing = workers - len(parts)
    compute = [name for name in LONGEST if not name.startswith(WATCHING)]
    long = [[item for item in items if item.nodeid.startswith(name)] for name in compute]
    rest = [item for item in items if not item.nodeid.startswith((*WATCHING, *LONGEST))]
    slow = [item for item in rest if item.get_closest_marker("slow")]
    quick = [item for item in rest if not item.get_closest_marker("slow")]
    for k in range(computing):
        first = [item for group in long[k::computing] for item in group]
        parts.append(first + _share(slow, k, computing))
    for k, part in enumerate(parts):
        lacking = max(0, len(_share(items, k, workers)) - len(part))
        part += quick[:lacking]
        del quick[:lacking]
    return [item for part in parts for item in part] + quick


def _share(items: Items, k: int, of: int) -> Items:
    """The k-th of so many equal parts."""
    return items[k * len(items) // of : (k + 1) * len(items) // of]


def step_back() -> None:
    """Leave the processor to the workers that watch, where a system has such a thing."""
    if hasattr(os, "nice"):
        os.nice(STEP_BACK)
