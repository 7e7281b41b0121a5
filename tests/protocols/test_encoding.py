"""Schedules as plain data."""

import copy
import json
import math

import pytest

from protocols import (
    Extras,
    Place,
    ScheduleError,
    make_schedule,
    run_from_dict,
    run_to_dict,
    schedule_from_dict,
    schedule_to_dict,
)
from protocols.extras.free_shapes import FreeShapes
from protocols.kinds.pulse_train import PulseTrain

EXTRAS = Extras(
    random_order_seed=3,
    remounts=1,
    no_touch_zero=True,
    added=(FreeShapes(),),
    dead_weights_N=(0.02,),
)
SCHEDULE = make_schedule(PulseTrain(), [Place("long", (0.0, 0.005))], extras=EXTRAS)


def test_a_schedule_survives_json():
    assert schedule_from_dict(json.loads(json.dumps(schedule_to_dict(SCHEDULE)))) == SCHEDULE


def test_a_run_survives_json():
    run = SCHEDULE.runs[-1]
    assert run_from_dict(json.loads(json.dumps(run_to_dict(run)))) == run


def damaged(change):
    data = copy.deepcopy(schedule_to_dict(SCHEDULE))
    change(data)
    return data


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda d: d.pop("protocol"), "schedule: the key 'protocol' is missing"),
        (lambda d: d.update(more=1), "schedule: the key 'more' is not known"),
        (lambda d: d["runs"][0].update(index=True), r"schedule.runs\[0\].index: a int is wanted"),
        (lambda d: d["runs"][0].update(index=1.0), r"index: a int is wanted, not 1.0"),
        (lambda d: d["runs"][1].update(purpose="x"), r"runs\[1\].purpose: 'x' is none of measure"),
        (lambda d: d["runs"][0].update(steps={}), r"runs\[0\].steps: a list is wanted"),
        (lambda d: d["runs"][0].update(readings=[3]), r"readings\[0\]: a table is wanted"),
        (lambda d: d["runs"][0].update(position_m="0"), "position_m: a float is wanted, not '0'"),
        (lambda d: d["runs"][0].update(moisten=0), "moisten: a bool is wanted, not 0"),
        (lambda d: d["runs"][0].update(duration_s=0.5), "not over when their step is"),
        (lambda d: d.update(frame_rate_hz=float("nan")), "frame_rate_hz"),
        (lambda d: d["runs"][0].update(tilt_rad=0.5), r"upright .* or is turned over .*, nothing"),
        (lambda d: d["runs"][0].update(tilt_rad=math.pi), "be turned over between two runs"),
    ],
)
def test_data_that_is_not_a_schedule_is_refused_by_the_name_of_its_key(change, says):
    with pytest.raises(ScheduleError, match=says):
        schedule_from_dict(damaged(change))


def test_a_schedule_from_before_a_rig_could_be_turned_over_is_that_of_an_upright_one():
    data = damaged(lambda d: [run.pop("tilt_rad") for run in d["runs"]])
    assert schedule_from_dict(data) == SCHEDULE
    over = make_schedule(PulseTrain(), [Place("long", (0.0,))], extras=Extras(turned_over=True))
    assert schedule_from_dict(json.loads(json.dumps(schedule_to_dict(over)))) == over


@pytest.mark.parametrize("data", [None, [], "x", 3])
def test_something_else_entirely_is_refused(data):
    with pytest.raises(ScheduleError, match="a table is wanted"):
        schedule_from_dict(data)


def test_whole_numbers_may_stand_for_numbers():
    data = damaged(lambda d: d.update(frame_rate_hz=25))
    assert schedule_from_dict(data).frame_rate_hz == 25.0
