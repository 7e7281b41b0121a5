"""What `labrig plan` shows."""

import pytest

from drivers.interfaces import VoltageWrite
from protocols import (
    Extras,
    Place,
    Purpose,
    ReadingKind,
    describe,
    lateness_of,
    make_schedule,
    timeline,
)
from protocols.execution.events import VoltageSet, Warned
from protocols.kinds.pulse_train import PulseTrain


def test_the_papers_position_in_numbers():
    plan = describe(make_schedule(PulseTrain(), [Place("long", (0.0, 0.005))]))
    first, second = plan.rows
    assert first.prompts == ("mount", "move to 0 mm", "touch", "moisten")
    assert second.prompts == ("move to 5 mm", "moisten")
    assert first.voltages_V == (2.0, -2.0)
    assert first.readings == {
        ReadingKind.ZERO: 10,
        ReadingKind.DISCARDED: 2,
        ReadingKind.KEPT: 20,
    }
    assert first.under_voltage_s == pytest.approx(13.2)
    assert plan.running_s == pytest.approx(38.4)
    assert plan.under_voltage_s == pytest.approx(26.4)
    assert second.starts_s > first.starts_s + first.duration_s
    assert plan.estimate_s > second.starts_s + second.duration_s


def test_extras_show_what_they_cost():
    extras = Extras(no_touch_zero=True, dead_weights_N=(0.02,))
    places = [Place("long", (0.0,))]
    plan = describe(make_schedule(PulseTrain(), places, extras=extras))
    assert [row.purpose for row in plan.rows] == [
        Purpose.DEAD_WEIGHT,
        Purpose.DEAD_WEIGHT,
        Purpose.NO_TOUCH_ZERO,
        Purpose.MEASUREMENT,
    ]
    assert plan.rows[1].prompts == ("dead_weight 20 mN",)
    assert plan.rows[2].prompts == ("dead_weight 0 mN", "mount", "move to 0 mm", "free")
    assert plan.estimate_s > describe(make_schedule(PulseTrain(), places)).estimate_s


def test_a_timeline_has_two_corners_at_each_edge():
    train = PulseTrain(zero_readings=1, pulses_discarded=0, readings_per_voltage=1)
    line = timeline(make_schedule(train, [Place("long", (0.0,))]).runs[0])
    assert line.time_s == (0, 0, 0, 0.6, 0.6, 1.2, 1.2, 1.8, 1.8, 1.8)
    assert line.voltage_V == (0, 0, 0, 0, 2, 2, -2, -2, 0, 0)
    assert line.reading_s == pytest.approx((0.5, 1.1, 1.7))
    assert line.reading_V == (0, 2, -2)


def test_lateness_is_counted_from_the_middle_of_the_write():
    events = [
        VoltageSet(
            1.0,
            run=0,
            step=i,
            due_s=1.0,
            write=VoltageWrite(2.0, 0.2, 1.0 + late_s - 1e-4, 1.0 + late_s + 1e-4),
        )
        for i, late_s in enumerate([0.001] * 98 + [0.002, 0.009])
    ]
    found = lateness_of([Warned(0.0, "x"), *events])
    assert found.edges == 100
    assert found.median_s == pytest.approx(0.001)
    assert found.worst_s == pytest.approx(0.009)
    assert 0.002 <= found.percentile99_s < 0.009
    assert lateness_of([]) is None
