"""The clearest pair of edges along a straightened strip."""

import numpy as np
import pytest

from labrig.vision.search.edge_pairs import edge_pairs
from labrig.vision.search.straightened import slopes

BLOCKS, COLUMNS, LOW, HIGH = 30, 61, 24, 36
RUN, RUN_SHARE, PRESENT = 4, 0.12, 0.5


def pairs(slope, apart, *, opposite=True):
    return edge_pairs(slope, apart, 3, opposite, RUN, RUN_SHARE, PRESENT)


def strip(ends_at=BLOCKS):
    slope = np.zeros((BLOCKS, COLUMNS))
    slope[:ends_at, LOW], slope[:ends_at, HIGH] = 5.0, -3.0
    return slope


def test_the_weaker_edge_of_the_pair_that_far_apart_counts_up_to_the_end():
    shown, edges = pairs(strip(ends_at=20), HIGH - LOW)
    assert edges.tolist() == [3.0] * 20
    assert shown == pytest.approx(60.0)


def test_edges_that_far_apart_are_not_seen_where_there_are_none():
    assert pairs(strip(), 20.0)[0] == 0


def test_two_rises_are_no_strip_unless_they_may_be():
    slope = np.abs(strip())
    assert pairs(slope, HIGH - LOW)[0] == 0
    assert pairs(slope, HIGH - LOW, opposite=False)[0] == pytest.approx(3.0 * BLOCKS)


def test_a_short_gap_is_passed_and_a_long_one_is_the_end():
    slope = strip()
    slope[10:13] = 0
    assert len(pairs(slope, HIGH - LOW)[1]) == BLOCKS
    slope[10:20] = 0
    assert len(pairs(slope, HIGH - LOW)[1]) == 10


def test_slopes_of_all_rows_at_once_are_those_of_each_row():
    rows = np.random.default_rng(2).normal(100, 30, (7, 40))
    rows[2, :5] = np.nan
    for blur in (0.8, 3.0, 9.0):
        together = slopes(rows, blur)
        assert np.array_equal(together, np.concatenate([slopes(row[None], blur) for row in rows]))
        assert not together[2, :5].any()
