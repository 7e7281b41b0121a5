"""A session with every extra: what is in its file, and what reads it."""

from __future__ import annotations

import csv
import json

import h5py
import numpy as np
import pytest

from labrig.config import ProtocolConfig
from labrig.experiment.replay import replay_plan
from labrig.experiment.resume import Resumption, resumed_plan
from labrig.panel.live.messages import MessageEncoder
from labrig.panel.replay.recorded_events import events_of
from labrig.session import load_measurements, open_session
from labrig.session.format.layout import MOVE_BEGAN, MOVE_ENDED
from labrig.testing import short_schedule
from protocols.execution import events as ev
from tests.end_to_end.small_rig import labrig, make_rig, run_rig
from tests.made_once import made_once

PROTOCOL = """
[pulse_train]
zero_readings = 1
pulses_discarded = 0
readings_per_voltage = 1

[[places]]
configuration = "long"
positions_mm = [5]

[extras]
reversed_approach = false
no_touch_zero = false

[extras.free_shapes]
rest_s = 0.5

[extras.release]
rest_s = 0.2
hold_s = 0.3
swing_s = 0.5

[extras.chirp]
duration_s = 1.0
end_hz = 5.0
amplitude_V = 1.5

[extras.load_cell_step]
to_mm = 20
rest_s = 0.2
follow_s = 0.5
"""
# The keys of a run in a schedule of before there were extras with runs of their own.
FORMER_KEYS = {
    "index", "configuration", "position_m", "purpose", "mounting", "approach", "moisten", "load_N",
    "steps", "readings", "duration_s", "via_m", "tilt_rad", "repeats",
}  # fmt: skip
NAMES = ["free_shapes", "release", "", "chirp", "load_cell_step"]

pytestmark = pytest.mark.slow


@pytest.fixture
def recorded(tmp_path_factory):
    """The path of a session; leave it as it is."""

    def make(folder):
        run_rig(make_rig(folder, PROTOCOL))
        assert labrig("replay", folder / "session.h5", "-o", folder / "replayed.h5") == 0
        assert labrig("analyze", folder / "replayed.h5") == 0

    return made_once(tmp_path_factory, "every-extra", make) / "session.h5"


def run_of(session, extra):
    return next(run for run in session.runs if run.planned.extra == extra)


def test_the_file_holds_series_and_frames_of_each_extra(recorded):
    with open_session(recorded) as session:
        assert [run.planned.extra for run in session.runs] == NAMES
        release = run_of(session, "release")
        times_s = release.frame_column("time")
        assert np.allclose(np.diff(times_s), 0.04, atol=1e-6)  # every frame
        assert times_s[0] < 0.0
        assert times_s[-1] > release.planned.duration_s - 0.04
        chirp = run_of(session, "chirp")
        drive_V = chirp.signal_V("drive")
        asked_V = np.interp(
            chirp.time_s,
            [step.time_s + 0.005 for step in chirp.planned.steps],
            [step.voltage_V for step in chirp.planned.steps],
            left=0.0, right=0.0,
        )  # fmt: skip
        assert np.sqrt(np.mean((drive_V - asked_V) ** 2)) < 0.1
        assert chirp.samples >= 1000
        assert len(chirp.writes) == len(chirp.planned.steps)


def test_a_step_of_the_load_cell_shows_in_the_force_and_in_the_log(recorded):
    with open_session(recorded) as session:
        step = run_of(session, "load_cell_step")
        time_s, force_V = step.time_s, step.signal_V("force")
        log = {e.kind: e for e in session.events if e.run == step.planned.index}
        zero_s = step.time_zero_s
    before, after = force_V[time_s < 0.18], force_V[time_s > 0.4]
    assert abs(after.mean() - before.mean()) > 5 * before.std()
    assert log[MOVE_BEGAN].text == "for 20 mm"
    assert log[MOVE_ENDED].text == "at 20 mm"
    assert log[MOVE_ENDED].time_s - zero_s >= 0.2 - 1e-6


def test_older_programs_know_every_key_of_the_schedule(recorded):
    with h5py.File(recorded) as file:
        schedule = json.loads(file["session/setup/schedule"][()])
        extras = json.loads(file["session/setup/extras"][()])
    assert {key for each in schedule["runs"] for key in each} == FORMER_KEYS
    assert [each["extra"] for each in extras.values()] == [name for name in NAMES if name]


def test_verify_and_show_name_the_extras(recorded, capsys):
    assert labrig("verify", recorded) == 0
    assert "run 2, release: frames" in capsys.readouterr().out
    assert labrig("show", recorded) == 0
    out = capsys.readouterr().out
    assert "load cell step" in out
    assert "long: at 0 V after 0.5 s (the sheet may still swing), none under voltage" in out


def test_replay_serves_the_series_and_the_frames(recorded):
    with open_session(recorded) as first, open_session(recorded.parent / "replayed.h5") as again:
        for extra in ("release", "chirp", "load_cell_step"):
            one, two = run_of(first, extra), run_of(again, extra)
            for channel in one.channels:
                assert np.array_equal(one.signal_V(channel), two.signal_V(channel))
        one, two = run_of(first, "release"), run_of(again, "release")
        missing = one.frame_count - two.frame_count
        assert missing in (0, 1)  # a frame of the lead-in comes before the camera looks
        assert np.array_equal(one.image(missing), two.image(0))


@pytest.mark.thorough
def test_a_resumed_session_gets_all_that_was_recorded_of_an_extra(recorded):
    events = []
    with open_session(recorded) as session:
        Resumption(session).publish(events.append, 1e4)
        frames = run_of(session, "release").frame_count
        log = {e.kind: e.time_s for e in session.events}
    kept = [f for e in events if isinstance(e, ev.FramesArrived) for f in e.frames]
    assert len(kept) == frames
    (left,) = [e for e in events if isinstance(e, ev.LoadCellLeft)]
    (arrived,) = [e for e in events if isinstance(e, ev.LoadCellArrived)]
    assert (left.position_m, arrived.reported_m) == (0.02, None)  # moved by hand
    assert arrived.time_s - left.time_s == pytest.approx(log[MOVE_ENDED] - log[MOVE_BEGAN])


def test_the_page_replays_the_move_of_the_load_cell(recorded):
    with open_session(recorded) as session:
        encoder = MessageEncoder()
        told = [encoder.message(event) for event in events_of(session)]
    logs = [message["log"] for message in told if message and message["type"] == "load_cell"]
    assert logs == ["the load cell leaves for 20 mm", "the load cell is at 20 mm"]


def test_a_session_is_replayed_and_resumed_with_its_own_schedule(recorded, monkeypatch):
    other = short_schedule(0.01)  # what another version of labrig makes of the same files
    monkeypatch.setattr(ProtocolConfig, "schedule", lambda _self, _name: other)
    with open_session(recorded) as session:
        assert replay_plan(session).schedule == session.schedule != other
        assert resumed_plan(session).schedule == session.schedule


@pytest.mark.thorough
def test_exports_say_which_series_is_an_extras(recorded, tmp_path):
    assert labrig("export", recorded.parent / "replayed.h5", "-o", tmp_path / "csv") == 0
    with (tmp_path / "csv" / "signals.csv").open(newline="") as file:
        extras = {row["extra"] for row in csv.DictReader(file)}
    assert extras == set(NAMES)
    options = ["--sheet", recorded.parent / "sheet.toml"]
    for name in ("forces", "curves", "signals"):
        options += [f"--{name}", tmp_path / "csv" / f"{name}.csv"]
    assert labrig("import", *options, "-o", tmp_path / "again.h5") == 0
    series = load_measurements(tmp_path / "again.h5").series
    assert sorted(each.extra for each in series) == sorted(NAMES)
