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
