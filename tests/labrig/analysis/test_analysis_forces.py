"""Forces from raw samples: where the edge was, what the filter gives, why a reading is invalid."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from labrig.analysis import measure, measure_forces, time_series
from labrig.analysis.edges import find_edges
from labrig.session import open_session
from protocols import Place, make_schedule
from protocols.execution import events as ev
from protocols.kinds.pulse_train import PulseTrain
from protocols.kinds.sine import Sine
from tests.cases import few
from tests.labrig.analysis.analysed import CALIBRATION, EDGE, change, record_with
from tests.labrig.session.session_recording import force_N, session_events, small_schedule

ONE_RUN = make_schedule(
    PulseTrain(zero_readings=2, readings_per_voltage=2), [Place("long", (0.005,))]
)


def measured(path, run=0):
    with open_session(path) as session:
        return measure_forces(session.runs[run], CALIBRATION)


def samples(edit):
    """Change the samples of all blocks: edit(volts, index of each sample)."""

    def change_block(event):
        volts = event.block.volts.copy()
        edit(volts, event.block.first_index + np.arange(volts.shape[1]))
        return replace(event, block=replace(event.block, volts=volts))

    return change(ev.SignalsArrived, change_block)


def writes(shift_s):
    """Writes that claim to have been made `shift_s` later than the edges the samples show."""

    def shift(event):
        write = event.write
        moved = replace(write, before_s=write.before_s + shift_s, after_s=write.after_s + shift_s)
        return replace(event, write=moved)

    return change(ev.VoltageSet, shift)


@pytest.mark.slow
def test_forces_are_those_of_the_samples_at_the_sampling_points(tmp_path):
    path = record_with(tmp_path / "s.h5", small_schedule())
    with open_session(path) as session:
        for run in session.runs:
            found = measure_forces(run, CALIBRATION)
            assert [r.index for r in found] == list(range(8))
            for reading in found:
                assert reading.valid, reading.why
                # The recording's noise is 7 uN a sample; the filter takes about a tenth of it.
                wanted_N = force_N(run.planned, reading.time_s)
                assert reading.force_N == pytest.approx(wanted_N, abs=4e-6)
                assert reading.noise_N == pytest.approx(0.8e-6, rel=0.5)
                assert reading.drive_V == pytest.approx(reading.voltage_V, abs=1e-9)


@pytest.mark.thorough
@pytest.mark.slow
def test_live_readings_do_not_matter(tmp_path):
    wrong = change(
        ev.ReadingTaken,
        lambda e: replace(
            e, sample_index=0.0, values=dict(e.values) | {"force_N": 99.0, "drive_V": 9.0}
        ),
    )
    plain = record_with(tmp_path / "a.h5", ONE_RUN)
    other = record_with(tmp_path / "b.h5", ONE_RUN, wrong)
    assert measured(plain) == measured(other)


@pytest.mark.slow
def test_a_zero_reading_is_timed_from_the_write_of_its_step(tmp_path):
    with open_session(record_with(tmp_path / "s.h5", ONE_RUN)) as session:
        run = session.runs[0]
        reading = measure_forces(run, CALIBRATION)[1]
        planned = run.planned.readings[1]
        assert reading.sample_index == pytest.approx(EDGE + planned.delay_s * 1000, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("shift_s", few([-4.3e-3, -0.2e-3, 0.3e-3, 2.7e-3]))
def test_an_edge_is_where_the_drive_shows_it_whatever_the_write_claims(tmp_path, shift_s):
    path = record_with(tmp_path / "s.h5", ONE_RUN, writes(shift_s))
    with open_session(path) as session:
        run = session.runs[0]
        edges = find_edges(run, run.signal_V("drive"))
        for step, planned in enumerate(run.planned.steps):
            if planned.voltage_V == 0.0 and step == 0:
                continue
            assert edges[step].index == pytest.approx(EDGE + planned.time_s * 1000, abs=0.61)
            assert edges[step].why == ""


@pytest.mark.slow
def test_between_two_samples_the_write_says_when(tmp_path):
    early = record_with(tmp_path / "s.h5", ONE_RUN, writes(-0.3e-3))
    with open_session(early) as session:
        run = session.runs[0]
        edges = find_edges(run, run.signal_V("drive"))
        planned = run.planned.steps[1]
        assert edges[1].index == pytest.approx(EDGE - 0.3 + planned.time_s * 1000, abs=1e-6)


@pytest.mark.slow
def test_a_slow_rise_begins_where_it_begins(tmp_path):
    """An amplifier's lag of 4 ms does not move the edge to the middle of the rise."""

    def lag(volts, index):
        volts[2] = np.interp(index, slow_index, slow_drive)

    blocks = [e.block.volts for e in session_events(ONE_RUN) if isinstance(e, ev.SignalsArrived)]
    drive = np.hstack(blocks)[2]
    slow_index = np.arange(drive.size)
    slow_drive = np.empty_like(drive)
    level = 0.0
    for i, value in enumerate(drive):
        level += (value - level) * (1 - np.exp(-1 / 4))
        slow_drive[i] = level
    path = record_with(tmp_path / "s.h5", ONE_RUN, samples(lag))
    with open_session(path) as session:
        run = session.runs[0]
        edges = find_edges(run, run.signal_V("drive"))
        for step, planned in enumerate(run.planned.steps[1:], start=1):
            assert edges[step].index == pytest.approx(EDGE + planned.time_s * 1000, abs=1.0)


@pytest.mark.slow
@pytest.mark.parametrize("write_every_s", few([0.02, 0.005]))
def test_a_waveform_in_large_steps_shows_its_edges(tmp_path, write_every_s):
    """Steps of up to 0.4 V, each shorter than the time over which levels are taken elsewhere."""
    sine = Sine(amplitude_V=2.0, frequency_hz=1.5, periods=2, write_every_s=write_every_s)
    schedule = make_schedule(sine, [Place("long", (0.005,))])
    readings = measured(record_with(tmp_path / "s.h5", schedule))
    assert len(readings) > 5
    assert [reading.why for reading in readings if reading.why] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("protocol", "told"), [(Sine(frequency_hz=1.5, periods=2), True), (PulseTrain(), False)]
)
def test_a_session_whose_voltage_is_never_held_says_what_that_means(tmp_path, protocol, told):
    schedule = make_schedule(protocol, [Place("long", (0.005,))])
    with open_session(record_with(tmp_path / "s.h5", schedule)) as session:
        warnings = measure(session, curves=False).warnings
    said = [text for text in warnings if "less than 0.1 s" in text]
    assert len(said) == int(told)
    assert all("fit --dynamic" in text for text in said)


@pytest.mark.slow
def test_a_waveform_that_the_drive_does_not_follow_spoils_its_readings(tmp_path):
    def dead(volts, index):
        volts[2] = 0.0

    sine = Sine(amplitude_V=2.0, frequency_hz=1.5, periods=2)
    schedule = make_schedule(sine, [Place("long", (0.005,))])
    readings = measured(record_with(tmp_path / "s.h5", schedule, samples(dead)))
    assert not any(reading.valid for reading in readings if abs(reading.voltage_V) > 0.2)


@pytest.mark.slow
def test_a_drive_that_stays_at_zero_spoils_its_readings(tmp_path):
    def dead(volts, index):
        volts[2] = 0.0

    for reading in measured(record_with(tmp_path / "s.h5", ONE_RUN, samples(dead))):
        if reading.voltage_V:
            assert not reading.valid
            assert "shows no edge within 50 ms" in reading.why
            assert "reads back" in reading.why
        else:
            assert reading.valid


@pytest.mark.slow
def test_a_drive_that_is_too_low_spoils_its_readings(tmp_path):
    def low(volts, index):
        volts[2] *= 0.8

    for reading in measured(record_with(tmp_path / "s.h5", ONE_RUN, samples(low))):
        assert reading.valid == (reading.voltage_V == 0.0)
        if not reading.valid:
            assert reading.why == (
                f"the drive reads back {0.8 * reading.voltage_V:.3g} V instead of "
                f"{reading.voltage_V:g} V"
            )


@pytest.mark.slow
def test_a_saturated_input_spoils_just_the_readings_whose_window_it_is_in(tmp_path):
    def clip(volts, index):
        volts[0, (index > 1290) & (index < 1310)] = 0.05

    found = measured(record_with(tmp_path / "s.h5", ONE_RUN, samples(clip)))
    assert [r.index for r in found if not r.valid] == [1]
    assert found[1].why == "the force input is at the end of its range (±0.05 V)"


@pytest.mark.slow
def test_lost_samples_spoil_the_reading_and_keep_its_live_value(tmp_path):
    def lose(event):
        block = event.block
        if block.first_index != 1300:
            return event
        return replace(event, block=replace(block, first_index=1310, volts=block.volts[:, 10:]))

    path = record_with(tmp_path / "s.h5", ONE_RUN, change(ev.SignalsArrived, lose))
    found = measured(path)
    assert [r.index for r in found if not r.valid] == [1]
    assert found[1].why == "samples were lost in its window"
    assert np.isfinite(found[1].force_N)


@pytest.mark.slow
def test_reasons_noted_while_running_stay_and_none_is_said_twice(tmp_path):
    def spoil(event):
        if event.planned.index != 3:
            return event
        why = "its edge came 9.0 ms late (limit 5 ms); the drive reads back 1.6 V instead of -2 V"
        return replace(event, valid=False, why=why)

    def wrong(volts, index):
        volts[2, volts[2] == -2.0] = 1.6

    path = record_with(tmp_path / "s.h5", ONE_RUN, change(ev.ReadingTaken, spoil), samples(wrong))
    reasons = measured(path)[3].why.split("; ")
    assert reasons[0].startswith("its edge came 9.0 ms late")
    assert len(reasons) == len(set(reasons))


@pytest.mark.slow
def test_a_person_s_mark_is_the_reason(tmp_path):
    def mark(event):
        if isinstance(event, ev.RunStopped):
            yield ev.ReadingMarked(
                event.time_s, run=event.run, reading=4, why="stuck in the rolls", who="anna"
            )

    found = measured(record_with(tmp_path / "s.h5", ONE_RUN, more=mark))
    assert [(r.index, r.why) for r in found if not r.valid] == [(4, "stuck in the rolls")]


@pytest.mark.slow
def test_a_run_that_never_began_has_no_readings(tmp_path):
    path = tmp_path / "s.h5"
    record_with(path, ONE_RUN)
    with open_session(path) as session:
        run = session.runs[0]
        run.__dict__["_acquisition"] = {"started": False}
        assert measure_forces(run, CALIBRATION) == ()


@pytest.mark.slow
def test_series_are_block_means_at_the_blocks_middles(tmp_path):
    with open_session(record_with(tmp_path / "s.h5", ONE_RUN)) as session:
        run = session.runs[0]
        series = time_series(run, CALIBRATION, shunt_ohm=2.0)
        assert np.diff(series.time_s) == pytest.approx(0.005)
        assert series.time_s[0] == pytest.approx(run.time_s[:5].mean())
        np.testing.assert_allclose(series.drive_V[3], run.signal_V("drive")[15:20].mean())
        np.testing.assert_allclose(series.current_A, series.drive_V * 0.01)
        wanted = force_N(run.planned, series.time_s)
        steady = np.abs(np.gradient(series.drive_V)) < 1e-6
        np.testing.assert_allclose(series.force_N[steady], wanted[steady], atol=2e-5)
