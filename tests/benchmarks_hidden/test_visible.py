"""How well something can be seen is measured with the conditions that are left."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.hidden_effects import case, hidden_session
from benchmarks.hidden_effects.in_common import in_common
from benchmarks.hidden_effects.visible import Yardstick
from model.measurements import Condition, Measurements

pytestmark = pytest.mark.thorough

HIDING = case("force_offset", size=0.5, seed=4, streams="means")


@pytest.fixture(scope="module")
def sessions() -> tuple[Measurements, Measurements]:
    """With nothing hidden, and with something."""
    return tuple(short(hidden_session(one).measurements) for one in (HIDING.bare, HIDING))


def short(m: Measurements) -> Measurements:
    """The same of one configuration."""
    conditions = tuple(c for c in m.conditions if c.configuration == "short")
    return replace(m, sheets={"short": m.sheets["short"]}, conditions=conditions, series=())


def spoiled(m: Measurements, count: int | None = None) -> Measurements:
    """The same, the sheet slipped out of the rolls at one place: so many readings do not count."""

    def one(c: Condition) -> Condition:
        if c.position_m is None or c.position_m < 0.029 or c.voltage_V <= 0.0:
            return c
        gone = len(c.readings) if count is None else count
        readings = [replace(r, valid=i >= gone) for i, r in enumerate(c.readings)]
        return replace(c, readings=tuple(readings), curve=None if count is None else c.curve)

    return replace(m, conditions=tuple(one(c) for c in m.conditions))


@pytest.mark.parametrize("count", [None, 4])
def test_what_has_become_invalid_is_compared_with_nothing(sessions, count):
    bare, hidden = sessions
    gone = spoiled(hidden, count)
    d = Yardstick(bare).length(gone)
    assert d == pytest.approx(Yardstick(spoiled(bare, count)).length(gone), rel=1e-9)
    assert 5.0 < d < Yardstick(bare).length(hidden)


def test_the_parts_of_a_pair_are_compared_where_all_are_valid(sessions):
    bare, hidden = sessions
    parts = [spoiled(hidden), hidden]
    found = Yardstick(bare).visible(hidden, parts, ["force_offset", "other"])
    assert found.alone[0] == pytest.approx(found.alone[1], rel=1e-9)


def test_sessions_that_hold_the_same_are_left_as_they_are(sessions):
    bare, hidden = sessions
    same = in_common([bare, hidden])
    assert same[0] is bare
    assert same[1] is hidden
    less, kept = in_common([hidden, spoiled(bare)])
    assert less is not hidden
    assert len(in_common([less, kept])) == 2
    assert in_common([less, kept])[0] is less
