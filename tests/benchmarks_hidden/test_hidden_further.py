"""The further measurement that is asked for is made as its protocol would make it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.hidden_effects import Hidden, case, hidden_session
from benchmarks.hidden_effects.further import driven_s, on_day, with_further
from benchmarks.hidden_effects.run import record
from benchmarks.hidden_effects.score import APART, right_after_further
from benchmarks.hidden_effects.suite import Task
from benchmarks.hidden_effects.visits import FURTHER
from labrig.config import parse_protocol
from labrig.experiment.next_measurement.next_protocol import protocol_text
from model import Measurements
from model.discrepancy import Next
from model.discrepancy.next_measurement.menu import MENU
from protocols.planning.schedule import PlannedRun, Purpose

pytestmark = pytest.mark.thorough

WEIGHT = case("gravity", size=0.01, seed=5)


@cache
def first() -> Hidden:
    return hidden_session(WEIGHT)


def test_every_entry_of_the_menu_can_be_made() -> None:
    assert set(FURTHER) == {entry.name for entry in MENU}


def position_of(run: PlannedRun) -> float | None:
    """Where the sheet touches the load cell."""
    return run.position_m if run.purpose is Purpose.MEASUREMENT else None


@pytest.mark.parametrize("extra", FURTHER)
def test_it_has_the_runs_of_the_protocol_that_is_proposed(extra: str) -> None:
    made = hidden_session(replace(WEIGHT, seed=6, further=extra)).measurements
    text = protocol_text(
        Next(why="", extra=extra, separation=0.0, expected=9.0, minutes=1.0, protocol={}),
        first().measurements,
    )
    planned = parse_protocol(text, "protocol.toml").schedule("protocol.toml").runs
    wanted = [
        (run.configuration, position_of(run), run.approach, run.tilt_rad, step.voltage_V)
        for run in planned
        for step in run.steps[:1] + run.steps[1:3]
    ]
    found = [
        (c.configuration, c.position_m, c.approach, c.tilt_rad, c.voltage_V)
        for c in made.conditions
    ]
    if extra == "random_order":  # not in the same one
        assert found != sorted(found, key=str)
        wanted, found = sorted(wanted, key=str), sorted(found, key=str)
    assert len(found) == len(wanted)
    for one, other in zip(found, wanted, strict=True):
        assert one[0] == other[0]
        assert one[1] == (None if other[1] is None else pytest.approx(other[1]))
        assert one[2:] == other[2:]


def test_weight_pulls_the_other_way_where_the_rig_is_turned_over() -> None:
    over = hidden_session(replace(WEIGHT, further="turned_over")).measurements
    for load, alike in ((-0.01, True), (0.01, False)):
        upright = hidden_session(case("gravity", size=load, seed=5, further="more_repeats"))
        forces = [
            [r.force_N for c in m.conditions for r in c.readings]
            for m in (over, upright.measurements)
        ]
        assert np.allclose(*forces, rtol=0.0, atol=1e-12) == alike


def swing_N(measured: Measurements) -> float:
    """How far 2 V move the force at the first position."""
    first_ = [c for c in measured.conditions if (c.configuration, c.position_m) == ("long", 0.0)]
    mean = {c.voltage_V: np.mean([r.force_N for r in c.used()]) for c in first_}
    return float(mean[2.0] - mean[0.0])


def test_an_eibm_that_is_worn_off_in_one_session_is_lost_to_the_next() -> None:
    wearing = case("eibm_drift", "for_good", size=0.2, seed=5)
    past_s = driven_s(wearing)
    assert past_s == pytest.approx(14 * 22 * 0.6)
    fresh, worn = (swing_N(on_day(wearing, seconds)) for seconds in (0.0, past_s))
    assert worn / fresh == pytest.approx(0.8, abs=0.01)
    drying = case("eibm_drift", "line", size=0.2, seed=5)  # until it is wetted again
    assert swing_N(on_day(drying, past_s)) == swing_N(on_day(drying, 0.0))


def test_both_sessions_have_the_same_sheet_and_nothing_else_in_common() -> None:
    bare = hidden_session(WEIGHT.bare).measurements
    both, visible = with_further(first(), bare, ["turned_over"])
    old, new = ([c for c in both.conditions if c.mounting == k] for k in (0, 1))
    assert len(old) == len(new) == len(first().measurements.conditions)
    for a, b in zip(old, new, strict=True):
        assert (a.configuration, a.position_m, a.voltage_V) == (
            b.configuration, b.position_m, b.voltage_V,
        )  # fmt: skip
        assert a.readings[0].force_N != b.readings[0].force_N
    assert min(visible.near.values()) > 0.9 * visible.d[0]  # nothing imitates weight any more


@pytest.mark.timeout(400)
def test_a_class_is_measured_further_and_judged_by_both_sessions() -> None:
    scale = case("camera_scale", "both", seed=3)
    kept = record(Task("ambiguous:0:0", "ambiguous", scale, "d", (16.0,)))
    assert kept.error == ""
    assert kept.further is not None
    assert {*kept.further.extra.split(", ")} <= {*FURTHER}
    assert {"camera_scale", "camera_perspective"} <= {*kept.further.reported}
    assert kept.further.nearest < APART
    assert kept.nearest > 1.2 * kept.further.nearest  # twice the data: 1.4 times as far
    assert right_after_further(kept)
