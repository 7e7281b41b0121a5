"""A session as its events tell it."""

import math
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from drivers.interfaces import Prompt
from labrig.testing.fake_rig import SHORT_TRAIN, FakeRig, short_schedule
from protocols import (
    Extras,
    LoopTiming,
    Place,
    RecordedOperator,
    Rules,
    RunState,
    ScheduleError,
    make_schedule,
)
from protocols.execution.events import (
    FramesArrived,
    OperatorAnswered,
    OperatorAsked,
    OperatorNotAsked,
    Outcome,
    OutputChanged,
    OutputState,
    ReadingMarked,
    ReadingTaken,
    RunStarted,
    RunStopped,
    SessionStarted,
    SessionStopped,
    SignalsArrived,
    VoltageSet,
    Warned,
)
from protocols.extras.free_shapes import FreeShapes
from protocols.kinds.hold import Hold
from protocols.kinds.pulse_train import PulseTrain


@pytest.fixture
def rig():
    return FakeRig()


def ends_well(rig, schedule=None, **settings):
    scheduler = rig.scheduler(**settings)
    assert scheduler.run(schedule or short_schedule()) is Outcome.COMPLETED
    return scheduler


def test_the_first_and_last_events_frame_the_session(rig):
    scheduler = ends_well(rig)
    assert isinstance(rig.events[0], SessionStarted)
    last = rig.events[-1]
    assert isinstance(last, SessionStopped)
    assert (last.outcome, last.output) == (Outcome.COMPLETED, OutputState.SAFE)
    assert scheduler.status.state is RunState.FINISHED
    times_s = [e.time_s for e in rig.events if not isinstance(e, RunStarted | SignalsArrived)]
    assert times_s == sorted(times_s)


def test_the_outputs_state_is_told_as_it_changes_and_ends_read_back(rig):
    ends_well(rig)
    states = [e.state for e in rig.of_kind(OutputChanged)]
    assert states == [
        OutputState.ARMED,
        OutputState.ENERGISED,
        OutputState.ARMED,
        OutputState.SAFE,
    ]


def test_the_guard_is_on_before_the_first_voltage_and_off_after_0_V(rig):
    order = []
    rig.output.faults.call = lambda name: order.append(("write", rig.output.clock.time_s))
    ends_well(rig, on_energised=lambda on: order.append((on, rig.clock.time_s)))
    names = [name for name, _ in order]
    # 0 V at the session's beginning, 0 V of the zero readings, three pulses, 0 V, 0 V at the end.
    assert names == ["write", "write", True, *["write"] * 4, False, "write"]


def test_it_beats_at_least_every_50_ms_while_a_run_is_under_way(rig):
    ends_well(rig)
    started = rig.of_kind(RunStarted)[0].time_s
    stopped = rig.of_kind(RunStopped)[0].time_s
    during = [beat for beat in rig.beats_s if started <= beat <= stopped]
    assert max(later - earlier for earlier, later in pairwise(during)) <= 0.05


@pytest.mark.parametrize("cost_s", [0.003, 0.007, 0.012, 0.016, 0.019])
def test_slow_services_do_not_make_edges_late(rig, cost_s):
    rig.signals.cost_s = cost_s  # of a look at the signals; one is due every 25 ms
    train = PulseTrain(pulse_s=0.6137)  # so that looks do not fall on edges
    ends_well(rig, make_schedule(train, [Place("long", (0.0,))]))
    late_s = [e.write.before_s - e.due_s for e in rig.of_kind(VoltageSet)]
    assert max(late_s) <= 1e-9
    assert all(reading.valid for reading in rig.of_kind(ReadingTaken))


def test_services_are_made_even_when_edges_are_too_close_to_leave_them_time(rig):
    train = PulseTrain(
        zero_readings=0,
        readings_per_voltage=100,
        pulse_s=0.03,
        sample_at_s=0.02,
        half_window_s=0.01,
    )
    rig.signals.cost_s = 0.02
    ends_well(rig, make_schedule(train, [Place("long", (0.0,))]))
    arrived = [e.time_s for e in rig.of_kind(SignalsArrived)]
    assert max(later - earlier for earlier, later in pairwise(arrived)) < 0.7


def test_samples_are_told_without_a_gap(rig):
    ends_well(rig)
    end = 0
    for event in rig.of_kind(SignalsArrived):
        assert event.block.first_index == end
        end += event.block.volts.shape[1]
    run = short_schedule().runs[0]
    timing = LoopTiming()
    assert end >= 1000 * (run.duration_s + timing.lead_in_s + timing.tail_s - 0.03)
    assert rig.of_kind(RunStopped)[0].lost_samples == 0


def test_a_reading_is_sampled_relative_to_its_edge_as_written_not_as_planned(rig):
    rig.output.stalls_s = {3: 0.004}  # the first pulse is written 4 ms late
    ends_well(rig)
    for reading in rig.of_kind(ReadingTaken):
        edge = next(e for e in rig.of_kind(VoltageSet) if e.step == reading.planned.step)
        middle_s = (edge.write.before_s + edge.write.after_s) / 2
        assert reading.sample_time_s == pytest.approx(middle_s + reading.planned.delay_s)
        clock = rig.of_kind(RunStarted)[0].sample_clock
        assert reading.sample_index == pytest.approx(clock.index_at(reading.sample_time_s))
        assert reading.valid
    late = next(r for r in rig.of_kind(ReadingTaken) if r.planned.step == 1)
    planned_s = rig.of_kind(RunStarted)[0].time_s + late.planned.delay_s + 1.2
    assert late.sample_time_s - planned_s == pytest.approx(0.0042, abs=1e-6)


def test_a_late_edge_spoils_its_own_reading_only_and_the_next_edge_is_on_time(rig):
    rig.output.stalls_s = {3: 0.0075}
    ends_well(rig)
    readings = rig.of_kind(ReadingTaken)
    assert [r.valid for r in readings] == [True, True, False, True, True]
    assert readings[2].why == "its edge came 7.7 ms late (limit 5 ms)"
    next_edge = rig.of_kind(VoltageSet)[2]
    assert next_edge.write.before_s == pytest.approx(next_edge.due_s)


def test_the_nearest_frame_goes_with_a_reading_and_its_offset_is_told(rig):
    ends_well(rig)
    for reading in rig.of_kind(ReadingTaken):
        taken_s = rig.camera.start_s + 0.04 * (reading.frame.number + 1)
        assert reading.frame.time_s == pytest.approx(taken_s)
        assert reading.frame_offset_s == pytest.approx(taken_s - reading.sample_time_s)
        assert abs(reading.frame_offset_s) <= 0.02 + 1e-9


def test_of_two_frames_equally_near_the_later_one_is_taken(rig):
    rig.camera.period_s = 0.6  # exactly a slot
    rig.camera.start_shift_s = 0.2 + 0.5 - 0.3 + rig.output.latency_s / 2
    ends_well(rig, rules=Rules(frame_periods=15))
    offsets_s = [r.frame_offset_s for r in rig.of_kind(ReadingTaken)]
    assert offsets_s == pytest.approx([0.3] * 5, abs=1e-6)


def test_a_lost_frame_is_a_reason_and_the_neighbour_takes_its_place_when_near_enough(rig):
    run = short_schedule().runs[0]
    zero_s = []

    def lost(time_s):
        start = rig.of_kind(RunStarted)[0].time_s
        zero_s.append(start)
        second = start + run.time_of(run.readings[1])
        third = start + run.time_of(run.readings[2])
        return abs(time_s - second) < 0.021 or abs(time_s - third) < 0.1

    rig.camera.lost = lost
    ends_well(rig)
    readings = rig.of_kind(ReadingTaken)
    assert [r.valid for r in readings] == [True, True, False, True, True]
    assert 0.02 < abs(readings[1].frame_offset_s) <= 0.06
    assert readings[2].frame is None
    assert readings[2].why == "no frame within 60 ms of the sampling point"


def test_a_frame_that_is_delivered_late_is_waited_for(rig):
    rig.camera.delivery_s = 0.25
    ends_well(rig)
    assert all(r.valid for r in rig.of_kind(ReadingTaken))
    assert all(abs(r.frame_offset_s) <= 0.02 + 1e-9 for r in rig.of_kind(ReadingTaken))


def test_without_a_camera_readings_have_no_frame_and_are_valid():
    rig = FakeRig(camera=False)
    ends_well(rig)
    assert rig.of_kind(RunStarted)[0].frame_shape is None
    assert all(r.valid and r.frame is None for r in rig.of_kind(ReadingTaken))


def test_all_frames_are_told_once_when_they_are_to_be_kept(rig):
    ends_well(rig, keep_all_frames=True)
    alone = [f.number for event in rig.of_kind(FramesArrived) for f in event.frames]
    with_readings = [r.frame.number for r in rig.of_kind(ReadingTaken)]
    assert sorted(alone + with_readings) == list(range(rig.of_kind(RunStopped)[0].frames_grabbed))
    assert alone == sorted(alone)


def test_an_input_at_the_end_of_its_range_spoils_the_readings_it_touches(rig):
    def spoil(times_s, volts):
        start = rig.of_kind(RunStarted)
        if start:
            near = np.abs(times_s - start[0].time_s - 1.1) < 0.05
            volts[0, near] = -0.05

    rig.signals.spoil = spoil
    ends_well(rig)
    why = [r.why for r in rig.of_kind(ReadingTaken)]
    assert why == ["", "the force input is at the end of its range (±0.05 V)", "", "", ""]


def test_a_drive_that_does_not_reach_the_sheet_spoils_the_readings(rig):
    rig.signals.spoil = lambda times_s, volts: volts.__setitem__(2, 0.0)
    ends_well(rig)
    readings = rig.of_kind(ReadingTaken)
    assert [r.valid for r in readings] == [True, True, False, False, False]
    assert readings[2].why == "the drive reads back 0 V instead of 2 V"


def test_lost_samples_are_counted_and_spoil_the_readings_they_belong_to(rig):
    rig.signals.skip = {54}
    ends_well(rig)
    readings = rig.of_kind(ReadingTaken)
    assert rig.of_kind(RunStopped)[0].lost_samples > 0
    assert sorted(r.valid for r in readings) == [False, True, True, True, True]
    spoilt = next(r for r in readings if not r.valid)
    assert "samples were lost in its window" in spoilt.why
    assert np.isnan(spoilt.values["force_N"])


def test_wetting_is_timed_from_the_operators_answer(rig):
    ends_well(rig, short_schedule(0.0, 0.005))
    moistened = [p.kind for p in rig.operator.asked].count("moisten")
    assert moistened == 2
    for event in rig.of_kind(RunStarted):
        assert event.since_wetting_s == pytest.approx(0.2, abs=1e-6)  # the lead-in


def test_a_sheet_that_was_never_wetted_says_so(rig):
    ends_well(rig, make_schedule(PulseTrain(), [Place("long", (0.0,))], moisten=False))
    assert rig.of_kind(RunStarted)[0].since_wetting_s is None


def test_the_operator_is_led_through_extras_in_a_sensible_order(rig):
    extras = Extras(no_touch_zero=True, added=(FreeShapes(),), remounts=1, dead_weights_N=(0.02,))
    told = []
    rig.operator.declines = lambda prompt: told.append(prompt.kind) or False
    move = rig.stage.move_to
    rig.stage.move_to = lambda p: told.append(f"{p * 1e3:g} mm") or move(p)
    ends_well(rig, make_schedule(SHORT_TRAIN, [Place("long", (0.01,))], extras=extras))
    assert told == [
        "dead_weight",  # none
        "dead_weight",  # 20 mN
        "dead_weight",  # taken off
        "mount", "free",  # free shapes at 0 V: nothing dries
        "10 mm", "free",
        "8 mm", "touch", "10 mm", "moisten",
        "remount", "10 mm", "touch", "moisten",
    ]  # fmt: skip
    assert len(rig.of_kind(OperatorAsked)) == len([t for t in told if "mm" not in t])
    loads_N = [p.load_N for p in rig.operator.asked if p.kind == "dead_weight"]
    assert loads_N == [0.0, 0.02, 0.0]


def test_the_rig_is_turned_over_once_before_everything_else(rig):
    extras = Extras(dead_weights_N=(0.02,), remounts=1, turned_over=True)
    places = [Place("long", (0.0, 0.01)), Place("short", (0.0,))]
    schedule = make_schedule(SHORT_TRAIN, places, extras=extras)
    ends_well(rig, schedule)
    kinds = [p.kind for p in rig.operator.asked]
    assert kinds[:2] == ["turn_over", "dead_weight"]
    assert kinds.count("turn_over") == 1
    assert kinds.count("mount") == 2
    assert {run.tilt_rad for run in schedule.runs} == {math.pi}
    upright = make_schedule(SHORT_TRAIN, places)
    assert {run.tilt_rad for run in upright.runs} == {0.0}


def test_a_manual_stages_questions_are_told_once_when_it_shares_the_operator(rig):
    recorded = RecordedOperator(rig.operator, rig.clock, rig.events.append)
    object.__setattr__(rig.devices, "operator", recorded)
    rig.stage.move_to = lambda p: recorded.ask(Prompt(kind="move", text="Move it.", position_m=p))
    rig.stage.position = lambda: None
    ends_well(rig)
    assert [e.prompt.kind for e in rig.of_kind(OperatorAsked)] == [
        "mount", "move", "touch", "moisten",
    ]  # fmt: skip
    assert all(e.done for e in rig.of_kind(OperatorAnswered))
    assert rig.of_kind(RunStarted)[0].stage_position_m is None


def test_where_nobody_was_asked_the_session_says_so_and_knows_no_time_since_wetting(rig):
    rig.operator.is_present = False
    ends_well(rig)
    assert [e.prompt.kind for e in rig.of_kind(OperatorNotAsked)] == ["mount", "touch", "moisten"]
    assert not rig.of_kind(OperatorAsked)
    assert not rig.of_kind(OperatorAnswered)
    assert [e.since_wetting_s for e in rig.of_kind(RunStarted)] == [None]


def test_the_time_since_wetting_is_known_where_the_operator_has_answered(rig):
    ends_well(rig)
    assert rig.of_kind(RunStarted)[0].since_wetting_s >= 0.0


def test_a_stage_that_stands_elsewhere_is_a_warning(rig):
    rig.stage.off_m = 0.0008
    ends_well(rig)
    assert rig.of_kind(RunStarted)[0].stage_position_m == pytest.approx(0.0008)
    assert "the stage reports 0.80 mm where run 1 wants 0 mm" in rig.of_kind(Warned)[0].text


@pytest.mark.parametrize("reported_m", [math.nan, math.inf])
def test_a_stage_that_reports_no_number_is_a_warning(rig, reported_m):
    rig.stage.position = lambda: reported_m
    ends_well(rig)
    assert rig.of_kind(Warned)[0].text == (
        f"the stage reports {reported_m} as its position, which is no number, "
        "where run 1 wants 0 mm"
    )
    assert rig.of_kind(RunStarted)[0].stage_position_m is None


def test_an_operators_answer_is_yes_or_no_whatever_it_is(rig):
    recorded = RecordedOperator(SimpleNamespace(ask=lambda _prompt: 1), rig.clock, lambda _: None)
    assert recorded.ask(Prompt(kind="touch", text="Touch it.")) is True


def test_runs_that_are_done_are_left_out_when_a_session_is_resumed(rig):
    scheduler = rig.scheduler()
    assert scheduler.run(short_schedule(0.0, 0.005, 0.01), done={0, 1}) is Outcome.COMPLETED
    assert [e.run.index for e in rig.of_kind(RunStarted)] == [2]
    assert rig.operator.asked[0].kind == "mount"


def test_readings_can_be_marked_once_they_are_taken(rig):
    scheduler = rig.scheduler()
    said = []

    def emit(event):
        rig.events.append(event)
        if isinstance(event, ReadingTaken) and event.planned.index == 1:
            scheduler.mark(0, 1, "the sheet stuck in the rolls", "AP")
            scheduler.mark(0, None, "all of it", "AP")
            for run, reading in ((0, 2), (1, 0)):
                with pytest.raises(ScheduleError) as refused:
                    scheduler.mark(run, reading, "", "")
                said.append(str(refused.value))

    scheduler._subscribers = emit
    assert scheduler.run(short_schedule()) is Outcome.COMPLETED
    assert [(m.run, m.reading, m.who) for m in rig.of_kind(ReadingMarked)] == [
        (0, 1, "AP"),
        (0, None, "AP"),
    ]
    assert said == [
        "reading 3 of run 1 has not been acquired yet",
        "run 2 has not begun, so nothing of it can be marked",
    ]
    with pytest.raises(ScheduleError, match="the session is over"):
        scheduler.mark(0, 1, "", "")


def test_two_sessions_on_two_clocks_are_the_same_event_by_event():
    sessions = []
    for _ in range(2):
        rig = FakeRig()
        ends_well(rig)
        sessions.append([_comparable(event) for event in rig.events])
    assert sessions[0] == sessions[1]


def _comparable(event):
    if isinstance(event, SignalsArrived):
        return (event.run, event.block.first_index, event.block.volts.tobytes())
    if isinstance(event, ReadingTaken):
        return (event.time_s, event.planned, event.values["force_N"], event.frame.number)
    return event


def test_a_hold_with_readings_closer_than_frames_gives_each_its_nearest_frame(rig):
    hold = Hold(hold_s=0.3, relax_s=0.3, cycles=1, sample_every_s=0.03)
    ends_well(rig, make_schedule(hold, [Place("long", (0.0,))]))
    readings = rig.of_kind(ReadingTaken)
    assert len(readings) == 27
    assert all(abs(r.frame_offset_s) <= 0.02 + 1e-9 for r in readings)


def test_a_scheduler_runs_one_session(rig):
    scheduler = ends_well(rig)
    with pytest.raises(ScheduleError, match="one session"):
        scheduler.run(short_schedule())
