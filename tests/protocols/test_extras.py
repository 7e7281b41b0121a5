"""Extras with runs of their own: what they plan, and how they are executed."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from drivers.interfaces import DeviceError
from labrig.config import EXTRAS
from labrig.testing import FakeRig, extra_faults, short_schedule
from labrig.testing.fake_rig import SHORT_TRAIN
from protocols import (
    Extras,
    Place,
    PlannedMove,
    Purpose,
    ReadingKind,
    SafetyLimits,
    ScheduleError,
    StopLevel,
    check_schedule,
    describe,
    make_schedule,
    run_to_dict,
    schedule_from_dict,
    schedule_to_dict,
)
from protocols.execution import events as ev
from protocols.execution.events import Outcome
from protocols.extras.chirp import Chirp
from protocols.extras.conformance import faults
from protocols.extras.contract import Extra, ExtraRun
from protocols.extras.free_shapes import FreeShapes
from protocols.extras.load_cell_step import LoadCellStep
from protocols.extras.release import Release
from protocols.kinds.hold import Hold
from protocols.kinds.pulse_train import PulseTrain
from protocols.kinds.staircase import Staircase
from protocols.planning.builder import Builder

LONG = Place("long", (0.0, 0.005, 0.010, 0.015, 0.020))
LIMITS = SafetyLimits(2.0, 30.0)


def runs_of(*extras, protocol=None, places=(LONG,)):
    found = make_schedule(protocol or PulseTrain(), places, extras=Extras(added=extras)).runs
    return [run for run in found if run.extra]


@pytest.mark.parametrize("name", sorted(EXTRAS.parts()))
def test_every_extra_keeps_to_the_contract(name):
    extra = EXTRAS.get(name)
    assert faults(extra) == []
    assert extra.name == name


def test_a_faulty_extra_is_told_what_is_wrong():
    class Nothing(Extra):
        """It plans nothing."""

        name = "nothing"

        def runs(self, protocol, positions_m):
            return iter(())

    @dataclass(frozen=True)
    class InMilliseconds(Extra):
        """One long pulse."""

        name = "in_milliseconds"

        def runs(self, protocol, positions_m):
            run = Builder()
            run.step(1.0, 600.0)
            run.reading(300.0, 0.01, ReadingKind.KEPT)
            yield ExtraRun(parts=run.finish())

    assert faults(Nothing) == ["it is no dataclass"]
    assert faults(InMilliseconds) == []  # the loader takes it: a rig may allow it
    (said,) = extra_faults(InMilliseconds)
    assert said.endswith("is 600 s under voltage: are its times in ms, not in s?")
    members = {"__annotations__": {"by_default": "bool"}, "by_default": True, "__doc__": "x"}
    shadowing = dataclass(frozen=True, kw_only=True)(type("Shadowing", (Release,), members))
    assert faults(shadowing)[0].startswith("its field by_default has a name that Extra uses")
    assert faults(int) == ["it is no subclass of protocols.extras.contract.Extra"]


def blink():
    run = Builder()
    run.step(1.0, 0.5)
    run.reading(0.3, 0.1, ReadingKind.KEPT)
    return run.finish()


def first(_protocol, positions_m):
    return [ExtraRun(parts=blink(), position_m=positions_m[0])]


@pytest.mark.parametrize(
    ("runs", "said"),
    [
        (lambda *_: None, "`runs` returned NoneType; it must yield each ExtraRun"),
        (lambda *_: ExtraRun(parts=blink()), "`runs` returned ExtraRun; it must yield each"),
        (lambda *_: [blink()], "`runs` must yield each ExtraRun; it yielded tuple"),
        (lambda *_: [ExtraRun(parts=blink(), position_m=12.0)], "is 12 m: is it in mm?"),
        (lambda *_: [ExtraRun(parts=blink(), position_m="5 mm")], "is '5 mm', no number in m"),
        (first, "where there are no positions (positions_m is empty) `runs` raised IndexError"),
    ],
)
def test_an_extra_whose_runs_are_none_is_told_what_it_returned(runs, said):
    @dataclass(frozen=True, kw_only=True)
    class Odd(Extra):
        """It returns something else."""

        name = "odd"

        def runs(self, protocol, positions_m):
            return runs(protocol, positions_m)

    (fault,) = extra_faults(Odd)
    assert said in fault


# ------------------------------------------------------------------------------------ free shapes


def test_free_shapes_are_taken_at_rest_and_come_before_the_positions():
    runs = make_schedule(
        PulseTrain(), [LONG, Place("short", (0.0,))], extras=Extras(added=(FreeShapes(),))
    ).runs
    free = [run for run in runs if run.purpose is Purpose.FREE_SHAPE]
    assert [run.index for run in free] == [0, 6]
    assert {run.position_m for run in free} == {None}
    assert [(run.steps[0].voltage_V, len(run.steps)) for run in free] == [(0.0, 1)] * 2
    assert [free[0].time_of(reading) for reading in free[0].readings] == [3.0, 3.6]
    assert not free[0].moisten  # nothing is driven


@pytest.mark.parametrize("protocol", [PulseTrain(), Staircase(), Hold(voltage_V=1.0)])
def test_free_shapes_under_voltage_wait_until_the_sheet_has_settled(protocol):
    (run,) = runs_of(FreeShapes(rest_s=5.0, settled_s=4.0), protocol=protocol)
    assert {reading.voltage_V for reading in run.readings} == {0.0, *protocol.driven_V}
    for reading in run.readings:
        assert reading.delay_s >= (4.0 if reading.voltage_V else 5.0)


def test_free_shapes_for_the_dynamic_model_are_taken_in_the_protocols_own_pulses():
    (run,) = runs_of(FreeShapes(moving=True))
    used = [r for r in run.readings if r.kind is not ReadingKind.DISCARDED]
    assert [r.voltage_V for r in used] == [0.0, 0.0, 2.0, -2.0, 2.0, -2.0]
    assert [r.delay_s for r in used] == [3.0, 3.6, 0.5, 0.5, 0.5, 0.5]


# ------------------------------------------------------------------------- release, chirp, step


def test_a_release_is_a_step_of_0_6_s_and_1_5_s_at_0_V_with_the_load_cell_away():
    (run,) = runs_of(Release())
    assert [(step.time_s, step.voltage_V) for step in run.steps] == [(0, 0), (3, 2), (3.6, 0)]
    assert run.duration_s == pytest.approx(5.1)
    assert (run.position_m, run.purpose, run.extra) == (None, Purpose.FREE_SHAPE, "release")
    assert run.keep_all_frames
    assert run.readings == ()


def test_a_release_of_several_voltages_is_a_run_each():
    runs = runs_of(Release(voltages_V=(1.0, -1.5), rest_s=0.0))
    assert [run.steps[0].voltage_V for run in runs] == [1.0, -1.5]


def test_a_release_takes_the_largest_positive_voltage_of_the_protocol():
    (run,) = runs_of(Release(), protocol=PulseTrain(voltages_V=(1.5, -2.0)))
    assert max(abs(step.voltage_V) for step in run.steps) == 1.5


def test_a_chirp_is_a_sine_whose_frequency_rises_between_its_limits():
    sweep = Chirp(start_hz=0.5, end_hz=8.0, duration_s=10.0, amplitude_V=1.5)
    (run,) = runs_of(sweep)
    assert (run.position_m, run.duration_s) == (0.010, 10.0)
    volts = np.array([step.voltage_V for step in run.steps])
    assert np.abs(volts).max() <= 1.5
    assert volts[-1] == 0.0
    # d phase/dt = 2 pi f0 (f1/f0)^(t/T)
    for time_s in (0.0, 3.0, 10.0):
        slope = (sweep.phase_rad(time_s + 1e-6) - sweep.phase_rad(time_s - 1e-6)) / 2e-6
        wanted_hz = 0.5 * (8.0 / 0.5) ** (time_s / 10.0)
        assert slope / (2 * math.pi) == pytest.approx(wanted_hz, rel=1e-6)
    # zero crossings: half of them for each turn of the phase
    crossings = int(np.count_nonzero(np.diff(np.sign(volts[:-1]))))
    assert crossings == math.floor(sweep.phase_rad(10.0) / math.pi)


def test_a_chirp_of_one_frequency_is_a_sine():
    sweep = Chirp(start_hz=2.0, end_hz=2.0)
    assert sweep.phase_rad(0.25) == pytest.approx(math.pi)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Chirp(end_hz=20.0), "less than 10 writes a period"),
        (lambda: Chirp(duration_s=3000.0), "more than 20000 writes"),
        (lambda: Chirp(start_hz=0.0), "start_hz = 0 must be larger than 0"),
        (lambda: LoadCellStep(from_mm=5.0, to_mm=5.0), "both 5 mm"),
        (lambda: FreeShapes(settled_s=3.0, moving=True), "choose one"),
    ],
)
def test_values_that_do_not_fit_are_refused_with_a_sentence(make, says):
    with pytest.raises(ScheduleError, match=says):
        make()


def test_a_step_of_the_load_cell_is_planned_at_0_V():
    (run,) = runs_of(LoadCellStep())
    assert {step.voltage_V for step in run.steps} == {0.0}
    assert (run.position_m, run.move) == (0.005, PlannedMove(1.0, 0.010))
    assert run.duration_s == 6.0
    assert not run.moisten


def test_contact_extras_come_after_the_positions_from_the_same_side():
    runs = make_schedule(
        PulseTrain(), [LONG], extras=Extras(added=(Chirp(), LoadCellStep()), reversed_approach=True)
    ).runs
    assert [run.extra for run in runs] == [""] * 5 + ["chirp", "load_cell_step", ""]
    for before, run in pairwise(runs[:-1]):
        stands_m = before.position_m if run.via_m is None else run.via_m
        assert stands_m < run.position_m
    assert runs[-1].via_m == pytest.approx(0.012)  # the load cell stands at 10 mm, moved there


def test_extras_are_measured_once_only():
    schedule = make_schedule(PulseTrain(), [LONG], extras=Extras(added=(Release(), Chirp())))
    assert len(schedule.repeats) == len(LONG.positions_m)


def test_a_place_without_positions_takes_what_needs_no_load_cell():
    nowhere = Place("long", ())
    assert [r.extra for r in runs_of(Release(), Chirp(), LoadCellStep(), places=[nowhere])] == [
        "release"
    ]
    with pytest.raises(ScheduleError, match="only extras without the load cell"):
        runs_of(Chirp(), places=[nowhere])


@pytest.mark.parametrize(
    ("extra", "says"),
    [
        (Release(voltages_V=(2.5,)), "2.5 V at the sheet is beyond the limit"),
        (Chirp(amplitude_V=2.2), "beyond the limit"),
        (Chirp(duration_s=31.0), "31 s under voltage is longer"),
    ],
)
def test_limits_hold_for_extras(extra, says):
    schedule = make_schedule(PulseTrain(), [LONG], extras=Extras(added=(extra,)))
    with pytest.raises(ScheduleError, match=says):
        check_schedule(schedule, LIMITS)


def test_time_under_voltage_counts_extras():
    plain = describe(make_schedule(PulseTrain(), [LONG])).under_voltage_s
    added = Extras(added=(Release(), Chirp()))
    more = describe(make_schedule(PulseTrain(), [LONG], extras=added)).under_voltage_s
    assert more - plain == pytest.approx(0.6 + 12.0, abs=0.05)


def test_a_schedule_with_extras_survives_json():
    added = Extras(added=(Release(), Chirp(duration_s=1.0), LoadCellStep()))
    schedule = make_schedule(PulseTrain(), [LONG], extras=added)
    assert schedule_from_dict(schedule_to_dict(schedule)) == schedule


def test_a_run_of_no_extra_is_written_as_before_there_were_any():
    plain = run_to_dict(make_schedule(PulseTrain(), [LONG]).runs[0])
    assert plain.keys().isdisjoint({"extra", "keep_all_frames", "move"})


# -------------------------------------------------------------------------------------- execution


@pytest.fixture
def rig():
    return FakeRig()


def schedule_of(*extras):
    return make_schedule(SHORT_TRAIN, [Place("long", (0.01,))], extras=Extras(added=extras))


def test_all_frames_of_a_release_are_kept_and_no_others(rig):
    assert rig.scheduler().run(schedule_of(Release())) is Outcome.COMPLETED
    kept = {event.run for event in rig.of_kind(ev.FramesArrived)}
    assert kept == {0}
    frames = [f for event in rig.of_kind(ev.FramesArrived) for f in event.frames]
    assert len(frames) >= 5.1 * 25
    assert [prompt.kind for prompt in rig.operator.asked][:2] == ["mount", "free"]


def test_the_load_cell_moves_while_samples_are_read(rig):
    assert rig.scheduler().run(schedule_of(LoadCellStep(follow_s=2.0))) is Outcome.COMPLETED
    (left,) = rig.of_kind(ev.LoadCellLeft)
    (arrived,) = rig.of_kind(ev.LoadCellArrived)
    assert rig.stage.moves[-2:] == [0.005, 0.010]
    assert arrived.time_s - left.time_s == pytest.approx(1.0)  # the fake stage takes a second
    started = next(e for e in rig.of_kind(ev.RunStarted) if e.run.index == left.run)
    stopped = next(e for e in rig.of_kind(ev.RunStopped) if e.run == left.run)
    assert left.time_s == pytest.approx(started.time_s + 1.0, abs=0.03)
    assert stopped.time_s - arrived.time_s >= 2.0
    volts = {e.write.sheet_V for e in rig.of_kind(ev.VoltageSet) if e.run == left.run}
    assert volts == {0.0}


def test_an_operator_who_declines_the_move_stops_the_session(rig):
    move = rig.stage.move_to

    def unless_from_5_mm(position_m):
        declined = rig.stage.moves[-1:] == [0.005]
        return move(position_m) and not declined

    rig.stage.move_to = unless_from_5_mm
    scheduler = rig.scheduler()
    assert scheduler.run(schedule_of(LoadCellStep())) is Outcome.ABORTED
    assert "asked to move the load cell" in scheduler.status.text
    assert rig.output.last_V == 0.0


def test_a_stage_that_answers_nothing_on_the_move_is_blamed(rig):
    move = rig.stage.move_to
    rig.stage.move_to = lambda p: None if rig.stage.moves[-1:] == [0.005] else move(p)
    scheduler = rig.scheduler()
    assert scheduler.run(schedule_of(LoadCellStep())) is Outcome.FAILED
    assert scheduler.status.text == ("the stage answered None to move_to, neither True nor False")
    assert rig.output.last_V == 0.0


def test_a_stage_that_fails_on_the_move_ends_the_session_at_0_V(rig):
    move = rig.stage.move_to

    def fails_from_5_mm(position_m):
        if rig.stage.moves[-1:] == [0.005]:
            raise DeviceError("the stage is stuck")
        return move(position_m)

    rig.stage.move_to = fails_from_5_mm
    scheduler = rig.scheduler()
    assert scheduler.run(schedule_of(LoadCellStep())) is Outcome.FAILED
    assert "stuck" in scheduler.status.text
    assert rig.output.last_V == 0.0
    assert rig.of_kind(ev.RunStopped)[-1].completed is False


@pytest.mark.parametrize("extra", [Release(), Chirp(duration_s=2.0)])
def test_stop_within_an_extra_returns_to_0_V(rig, extra):
    schedule = schedule_of(extra)
    run = next(run for run in schedule.runs if run.extra)

    def stop_when_energised(event):
        if isinstance(event, ev.VoltageSet) and event.run == run.index and event.write.sheet_V:
            rig.stop.request(StopLevel.NOW, "by the test")

    assert rig.scheduler(emit=stop_when_energised).run(schedule) is Outcome.ABORTED
    assert rig.output.last_V == 0.0


def test_a_session_without_extras_has_none_of_their_events(rig):
    rig.scheduler().run(short_schedule())
    assert not rig.of_kind(ev.FramesArrived)
    assert not rig.of_kind(ev.LoadCellLeft)
