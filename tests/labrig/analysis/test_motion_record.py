"""What a session recorded of a moving sheet, as the model takes it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from labrig.analysis.motion import motion_record, recorded_runs
from labrig.analysis.motion.record import moving_configurations
from labrig.errors import BadInputError
from labrig.session import add_mark, open_session
from labrig.session.marks.mark import Mark
from model.dynamics import Resolution
from model.dynamics.identification.predicted_run import predict
from tests.labrig.moving_session import TRUTH, moving_session

pytestmark = pytest.mark.slow  # a session is recorded, and some fifty images are measured


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return moving_session(tmp_path_factory)


@pytest.fixture(scope="module")
def record(path):
    with open_session(path) as session:
        return motion_record(session)


def rms(values):
    return float(np.sqrt(np.nanmean(np.square(values))))


def test_the_runs_are_the_free_release_and_the_pulses_in_contact(record):
    free, held = record.runs
    assert free.plan.setup is None
    assert free.force_N is None
    assert free.plan.name == "long, free, release"
    assert held.plan.setup.position_m == 0.005
    assert held.plan.setup.radius_m == pytest.approx(0.04)
    assert held.force_N.shape == held.current_A.shape == held.plan.time_s.shape
    assert np.median(np.diff(held.plan.time_s)) == pytest.approx(1e-3)
    assert {run.plan.configuration for run in record.runs} == {"long"}
    assert record.missing == ()


def test_a_run_begins_half_a_second_before_its_first_voltage_as_written(record):
    for run, volts in zip(record.runs, ([1.0, 0.0], [2.0, -2.0, 2.0, -2.0, 0.0]), strict=True):
        drive = run.plan.drive
        within = drive.time_s > 0.0
        written = drive.voltage_V[within] - drive.voltage_V[0]
        assert written == pytest.approx(volts, abs=1e-9)
        assert np.diff(drive.time_s[within]) == pytest.approx(0.6, abs=1e-6)
        assert drive.time_s[within][0] == pytest.approx(0.5, abs=1e-6)


def test_what_came_before_a_run_and_the_offset_of_the_amplifier_are_in_its_drive(record):
    free, held = (run.plan.drive for run in record.runs)
    assert free.voltage_V[0] == pytest.approx(0.010, abs=1e-3)  # 1 mV at its input
    before = held.time_s < 0.0
    assert held.voltage_V[before] - held.voltage_V[0] == pytest.approx([0.0, 1.0, 0.0], abs=1e-9)


def test_the_true_sheet_predicts_the_recorded_current_and_force(record):
    for run in record.runs:
        said = predict(TRUTH, run.plan, Resolution())
        edges = run.plan.drive.time_s
        away = np.min(np.abs(run.plan.time_s[:, None] - edges), axis=1) > 1e-3
        assert rms((run.current_A - said.current_A)[away]) < 7e-5  # noise and steps of the input
        if run.plan.force:
            assert rms(run.force_N - said.force_N) < 1.5e-4  # noise, drift and hum


def test_the_true_sheet_predicts_the_single_frames_at_the_middle_of_their_exposure(record):
    run = record.runs[0]
    assert len(run.plan.frame_s) > 40
    assert np.isfinite(run.x_m).mean() > 0.9

    def away(delay_s):
        said = predict(TRUTH, replace(run.plan, frame_s=run.plan.frame_s + delay_s), Resolution())
        dx, dy = run.x_m - said.x_m, run.y_m - said.y_m
        return np.cos(said.phi_rad) * dy - np.sin(said.phi_rad) * dx

    assert rms(away(0.0)) < 1.5e-5
    assert rms(away(2.5e-3)) > 2 * rms(away(0.0))  # the end of the exposure is not it


def test_without_its_images_a_session_is_read_at_once(path):
    with open_session(path) as session:
        free, held = motion_record(session, frames=False).runs
    assert len(free.plan.frame_s) == len(held.plan.frame_s) == 0


def test_only_some_positions_and_marked_runs_are_left_out(path, tmp_path):
    with open_session(path) as session:
        found = motion_record(session, positions_m=[0.015], frames=False)
    assert [run.plan.setup for run in found.runs] == [None]
    copy = tmp_path / "session.h5"
    copy.write_bytes(path.read_bytes())
    add_mark(copy, Mark(run=2, reading=None, why="slipped", who="Ann"))
    with open_session(copy) as session:
        found = motion_record(session, frames=False)
    assert [run.plan.setup for run in found.runs] == [None]
    assert any("No force was recorded" in text for text in found.missing)


@pytest.mark.thorough
def test_what_was_not_recorded_is_said_with_what_to_do(path, monkeypatch):
    with open_session(path) as session:
        monkeypatch.setitem(session.resolved["rig"], "current_sense", {})
        monkeypatch.delitem(session.resolved["rig"]["camera"], "exposure_s")
        found = motion_record(session)
    assert all(run.current_A is None for run in found.runs)
    current, exposure = found.missing
    assert "state [current_sense] shunt_ohm in rig.toml" in current
    assert "state [camera] exposure_s in rig.toml" in exposure
    with open_session(path) as session:
        found = motion_record(session, frames=False)
    assert any("add [extras] release = true" in text for text in found.missing)


def test_a_session_without_signals_or_without_motion_is_refused_in_a_sentence(path):
    with open_session(path) as session:
        assert moving_configurations(session) == ["long"]
        with pytest.raises(BadInputError, match="no whole run of 'short' was driven"):
            recorded_runs(session, "short")
        session.runs = ()
        with pytest.raises(BadInputError, match="no signals over time, only tables"):
            recorded_runs(session)
