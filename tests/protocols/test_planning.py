"""Extras, order, approaches."""

from itertools import pairwise

import pytest

from protocols import (
    Extras,
    Place,
    Purpose,
    ReadingKind,
    ScheduleError,
    make_schedule,
)
from protocols.extras.free_shapes import FreeShapes
from protocols.kinds.pulse_train import PulseTrain

POSITIONS_M = (0.0, 0.005, 0.010, 0.015, 0.020, 0.025, 0.030)
LONG = Place("long", POSITIONS_M)
SHORT = Place("short", POSITIONS_M)


def positions(schedule, configuration="long"):
    return [r.position_m for r in schedule.runs if r.configuration == configuration]


def test_a_random_order_is_a_shuffle_that_its_seed_repeats():
    one = make_schedule(PulseTrain(), [LONG, SHORT], extras=Extras(random_order_seed=7))
    two = make_schedule(PulseTrain(), [LONG, SHORT], extras=Extras(random_order_seed=7))
    other = make_schedule(PulseTrain(), [LONG, SHORT], extras=Extras(random_order_seed=8))
    assert one == two
    assert positions(one) != positions(other)
    assert sorted(positions(one)) == list(POSITIONS_M)
    assert positions(one) != list(POSITIONS_M)
    assert positions(one) != positions(one, "short")


def test_a_random_order_still_comes_to_every_position_from_below():
    runs = make_schedule(PulseTrain(), [LONG], extras=Extras(random_order_seed=7)).runs
    for before, run in pairwise(runs):
        came_from_m = before.position_m if run.via_m is None else run.via_m
        assert came_from_m < run.position_m


def test_a_no_touch_zero_precedes_each_position_at_0_V_with_nothing_in_contact():
    runs = make_schedule(PulseTrain(), [LONG], extras=Extras(no_touch_zero=True)).runs
    assert [r.purpose for r in runs] == [Purpose.NO_TOUCH_ZERO, Purpose.MEASUREMENT] * 7
    for zero, run in zip(runs[::2], runs[1::2], strict=True):
        assert zero.position_m == run.position_m
        assert {s.voltage_V for s in zero.steps} == {0.0}
        assert {r.kind for r in zero.readings} == {ReadingKind.NO_CONTACT}
        assert len(zero.readings) == 10
        assert not zero.moisten
        assert run.via_m == pytest.approx(run.position_m - 0.002)  # put back, then approached


def test_the_middle_position_is_approached_from_above_as_well():
    runs = make_schedule(PulseTrain(), [LONG], extras=Extras(reversed_approach=True)).runs
    assert [r.approach for r in runs] == ["up"] * 7 + ["down"]
    # The position before is 30 mm, so going straight to 15 mm is coming from above.
    assert (runs[-1].position_m, runs[-1].via_m) == (0.015, None)


def test_a_reversed_approach_goes_past_the_position_when_it_stands_below():
    extras = Extras(reversed_approach=True, approach_from_m=0.001)
    runs = make_schedule(PulseTrain(), [Place("long", (0.030, 0.0, 0.015))], extras=extras).runs
    assert [r.via_m for r in runs] == [None, -0.001, None, 0.016]


def test_remounts_are_spread_over_the_positions_and_numbered():
    runs = make_schedule(PulseTrain(), [LONG], extras=Extras(remounts=3)).runs
    again = [(r.position_m, r.mounting) for r in runs if r.mounting]
    assert again == [(0.0, 1), (0.015, 1), (0.030, 1)]
    more = make_schedule(PulseTrain(), [Place("x", (0.0, 0.01))], extras=Extras(remounts=5)).runs
    assert [(r.position_m, r.mounting) for r in more if r.mounting] == [
        (0.0, 1), (0.01, 1), (0.0, 2), (0.01, 2), (0.0, 3),
    ]  # fmt: skip


def test_dead_weights_come_first_and_begin_with_none():
    runs = make_schedule(PulseTrain(), [LONG], extras=Extras(dead_weights_N=(0.02, 0.05))).runs
    assert [r.load_N for r in runs[:4]] == [0.0, 0.02, 0.05, None]
    assert {r.purpose for r in runs[:3]} == {Purpose.DEAD_WEIGHT}


def test_runs_are_numbered_in_their_order():
    extras = Extras(
        random_order_seed=3,
        remounts=2,
        no_touch_zero=True,
        added=(FreeShapes(),),
        reversed_approach=True,
        dead_weights_N=(0.02,),
    )
    runs = make_schedule(PulseTrain(), [LONG, SHORT], extras=extras).runs
    assert [r.index for r in runs] == list(range(len(runs)))


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: make_schedule(PulseTrain(), []), "there is none"),
        (lambda: make_schedule(PulseTrain(), [LONG, LONG]), "there twice"),
        (lambda: make_schedule(PulseTrain(), [LONG], frame_rate_hz=0.0), "frame_rate_hz = 0"),
        (lambda: make_schedule(PulseTrain(), [Place("long", ())]), "long has no positions"),
        (lambda: Extras(approach="left"), "should be up or down"),
        (lambda: Place("", (0.0,)), "no name"),
        (lambda: Place("long", (0.0, 0.0)), "there twice"),
        (lambda: Place("long", (float("nan"),)), "not a finite number"),
        (lambda: Extras(remounts=-1), "remounts = -1"),
        (lambda: Extras(dead_weights_N=(0.0,)), "dead weight"),
    ],
)
def test_nonsense_is_refused(make, says):
    with pytest.raises(ScheduleError, match=says):
        make()
