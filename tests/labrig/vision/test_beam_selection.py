"""The search for a path keeps the best states after each step, few of one place."""

from __future__ import annotations

import numpy as np
import pytest

from labrig.vision.search.beam_selection import ANGLE, KINDS, SCORE, U, V, select

FINE = 0.1


def kept(child, bend, width):
    """Return the rows that should be kept, by sorting all of them."""
    kinds, rows = dict[tuple[float, ...], int](), list[int]()
    for t in np.argsort(-child[:, SCORE], kind="stable"):
        place = (*np.floor(child[t, [U, V]] / 2.0), np.floor(child[t, ANGLE] / FINE), bend[t] // 3)
        kinds[place] = kinds.get(place, 0) + 1
        if kinds[place] <= 2:
            rows.append(int(t))
    return rows[:width]


@pytest.mark.parametrize(("count", "width"), [(1, 4), (7, 4), (60, 12), (60, 60), (500, 40)])
def test_the_best_are_kept_two_of_a_kind_and_the_best_comes_first(count, width):
    random = np.random.default_rng(count)
    child = np.zeros((count, 6))
    child[:, U], child[:, V] = random.integers(0, 60, count), 20.0  # few, lest two hashes agree
    child[:, ANGLE] = random.choice([0.05, 0.15], count)
    child[:, SCORE] = random.permutation(count)
    bend = np.zeros(count, dtype=np.int64)
    chosen = np.zeros(width, dtype=np.int64)
    best_two = np.full((KINDS, 2), -1, dtype=np.int64)
    for _ in range(2):  # the room for the best two is as before
        many = select(child, bend, count, width, FINE, chosen, best_two)
        rows, wanted = chosen[:many].tolist(), kept(child, bend, width)
        assert rows[0] == wanted[0]
        assert sorted(rows) == sorted(wanted)
