"""A number with its uncertainty: its interval, and the same in a file."""

from __future__ import annotations

import pytest

from model.parameter import Parameter


def test_what_is_positive_has_a_positive_interval():
    tau = Parameter(value=0.06, sigma=0.06, unit="s", freedom=12.0, positive=True)
    low, high = tau.interval()
    assert 0.0 < low < 0.06 < high
    assert low * high == pytest.approx(0.06**2)  # even in its logarithm
    plain = Parameter(value=0.06, sigma=0.06, unit="s", freedom=12.0).interval()
    assert plain[0] < 0.0
    sure = Parameter(value=0.06, sigma=6e-5, unit="s", freedom=12.0, positive=True)
    assert sure.interval() == pytest.approx(
        Parameter(value=0.06, sigma=6e-5, unit="s", freedom=12.0).interval(), rel=1e-5
    )


def test_it_is_the_same_in_a_file_and_in_another_unit():
    tau = Parameter(value=0.06, sigma=0.06, unit="s", freedom=12.0, positive=True)
    assert Parameter.from_dict(tau.to_dict(), "tau") == tau
    assert tau.scaled(1e3, "ms").interval() == pytest.approx([1e3 * x for x in tau.interval()])
    assert "positive" not in Parameter(value=1.0, sigma=0.1, unit="N").to_dict()


def test_the_interval_of_a_share_ends_where_shares_end():
    share = Parameter(
        value=0.81, sigma=0.31, unit="", freedom=12.0, positive=True, low=0.05, high=1.0
    )
    low, high = share.interval()
    assert 0.05 < low < 0.81
    assert high == pytest.approx(1.0)
    beyond = Parameter(value=0.81, sigma=0.31, unit="", freedom=12.0, positive=True).interval()
    assert beyond[1] > 1.5
    assert low > beyond[0]  # what is beyond the bound does not count


def test_a_value_at_its_bound_is_in_its_interval_and_far_bounds_change_nothing():
    low, high = Parameter(value=0.0, sigma=0.1, unit="", low=0.0, high=1.0).interval()
    assert low == 0.0
    assert high == pytest.approx(0.1 * 1.645, rel=1e-3)  # the 90 % of one half of a normal
    plain, bounded = (
        Parameter(value=0.5, sigma=0.01, unit="", freedom=9.0, **bounds).interval()
        for bounds in ({}, {"low": 0.0, "high": 1.0})
    )
    assert bounded == pytest.approx(plain, rel=1e-9)
    wide = Parameter(value=0.5, sigma=50.0, unit="", low=0.0, high=1.0).interval()
    assert wide == pytest.approx((0.05, 0.95), abs=1e-3)


def test_bounds_are_the_same_in_a_file_and_go_with_the_unit():
    share = Parameter(value=0.81, sigma=0.31, unit="", low=0.05, high=1.0)
    assert Parameter.from_dict(share.to_dict(), "share") == share
    assert share.scaled(100.0, "%").interval() == pytest.approx(
        [100.0 * x for x in share.interval()]
    )
    assert share.scaled(-1.0, "").high == -0.05
