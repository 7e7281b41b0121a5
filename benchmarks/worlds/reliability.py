"""How often what is said with a probability is so: lines of a table, a bin of probability each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from benchmarks.hidden_effects.score import Row, wilson

BINS = (0.0, 0.5, 0.8, 0.9, 0.95, 0.99, 1.0)
Told = tuple[str, float, bool]  # key of the case, probability, whether it is so


def reliability(what: str, told: Sequence[Told]) -> list[Row]:
    """Return a line for each bin; its goal is the mean probability, within the interval."""
    result = []
    for low, high in pairwise(BINS):
        own = [t for t in told if low <= t[1] < high or t[1] == high == BINS[-1]]
        mean = float(np.mean([p for _, p, _ in own])) if own else 0.0
        line = f"{what}, where its probability is {low:g} - {high:g}"
        result.append(share(line, f"{mean:.1%}", [(k, ok) for k, _, ok in own]))
    return result


def share(
    what: str, goal: str, told: Sequence[tuple[str, bool]],
    met: Callable[[float], bool] | None = None,
) -> Row:  # fmt: skip
    """Return a share with its interval; without `met` the interval must hold the goal."""
    hits, count = sum(ok for _, ok in told), len(told)
    if not count:
        return Row(what, goal, "-", 0)
    low, high = wilson(hits, count)
    good = met(hits / count) if met else low <= float(goal.rstrip("%")) / 100.0 <= high
    return Row(what, goal, f"{hits / count:.1%}", count, f"{low:.1%} - {high:.1%}", good)
