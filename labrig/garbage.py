"""How often Python looks for garbage that refers to itself."""

from __future__ import annotations

import gc

# Objects that came and have not gone, and passes, before the next pass. Python has 700, 10, 10.
_THRESHOLDS = (10_000, 10, 10)


def look_for_garbage_seldom() -> None:
    """Let fewer passes hold a process of labrig up; for programs, not for whoever imports it.

    While a process loads what it needs they take a tenth of its time, and in a run any of them may
    come just before an edge. A run leaves no more such garbage the longer it lasts.
    """
    gc.set_threshold(*_THRESHOLDS)
