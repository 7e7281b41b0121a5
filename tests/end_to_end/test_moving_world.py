"""`labrig run` in the moving world, on the virtual clock and over sockets, against `simulate`."""

from __future__ import annotations

import itertools
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from drivers.interfaces import FloatArray
from labrig.model_file import save_model
from labrig.session import RecordedSession, load_measurements, open_session
from model.measurements import TimeSeries
from protocols.execution.events import Outcome, OutputState
from sim_hardware import world
from tests.end_to_end.real_rig import serving
from tests.end_to_end.small_rig import labrig, make_rig, run_rig
from tests.labrig.moving_model import model
from tests.made_once import made_once

pytestmark = [pytest.mark.slow, pytest.mark.timeout(240)]

PROTOCOL = """
[pulse_train]
zero_readings = 2
readings_per_voltage = 2

[[places]]
configuration = "long"
positions_mm = [5]

[extras]
random_order = false
no_touch_zero = false
reversed_approach = false
free_shapes = false
release = true
"""
SHIPPED = Path(world.__file__).with_name("moving.toml")
STILL_SETUPS = SHIPPED.read_text() + "\n[scatter]\neibm = 0.0\nstiffness = 0.0\nposition_mm = 0.0\n"
RELEASE, CONTACT = 1, 2  # runs of it


@pytest.fixture(scope="module")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A rig's folder with a session of the moving world, and the world's sheet as a model file."""

    def make(folder: Path) -> None:
        session = run_rig(make_rig(folder, PROTOCOL, STILL_SETUPS))
        assert labrig("analyze", session) == 0
        save_model(model(points=401, negative_ratio=0.8), folder / "model.toml")

    return made_once(tmp_path_factory, "moving-world", make)


def simulated(rig: Path, run: int) -> dict[str, FloatArray]:
    """What `labrig simulate --time` writes of a run of the protocol."""
    files = [rig / "model.toml", "--time", "--drive", rig / "protocol.toml", "--run", run]
    assert labrig("simulate", *files, "--force", "-o", rig / "motion.h5") == 0
    with h5py.File(rig / "motion.h5") as file:
        entry = file["entry"]
        return {name: data[:] for part in ("motion", "shape") for name, data in entry[part].items()}


def recorded(rig: Path, run: int) -> TimeSeries:
    """What the session holds of it: means over 5 ms."""
    name = {RELEASE: "release", CONTACT: ""}[run]
    (found,) = (one for one in load_measurements(rig / "session.h5").series if one.extra == name)
    return found


def difference(found: TimeSeries, values: FloatArray, motion: dict[str, FloatArray]) -> FloatArray:
    """Measured less simulated, less its mean; without edges, which lie within a mean of 5 ms."""
    expected = np.interp(found.time_s, motion["time_s"], values)
    drive = np.interp(found.time_s, motion["time_s"], motion["drive_V"])
    measured = found.force_N if values is motion["force_N"] else found.current_A
    assert measured is not None
    calm = (
        (np.abs(np.gradient(drive)) < 1e-6)
        & (found.time_s >= 0)
        & (found.time_s < motion["time_s"][-1])
    )
    gap = (measured - expected)[calm]
    return gap - np.mean(gap)


@pytest.mark.thorough
def test_force_and_current_of_its_session_are_those_of_its_sheets_model(rig: Path) -> None:
    found, motion = recorded(rig, CONTACT), simulated(rig, CONTACT)
    assert np.ptp(motion["force_N"]) > 2e-3
    assert np.sqrt(np.mean(difference(found, motion["force_N"], motion) ** 2)) < 0.07e-3
    assert np.ptp(motion["current_A"]) > 40e-3
    assert np.sqrt(np.mean(difference(found, motion["current_A"], motion) ** 2)) < 0.3e-3


@pytest.mark.thorough
def test_its_release_is_free(rig: Path) -> None:
    found, motion = recorded(rig, RELEASE), simulated(rig, RELEASE)
    assert found.force_N is None
    assert np.ptp(motion["current_A"]) > 40e-3
    assert np.sqrt(np.mean(difference(found, motion["current_A"], motion) ** 2)) < 0.04e-3


@pytest.mark.thorough
def test_its_frames_show_a_sheet_that_swings(rig: Path) -> None:
    with open_session(rig / "session.h5") as session:
        assert_swings(session)


@pytest.mark.thorough
@pytest.mark.alone
@pytest.mark.skipif(sys.platform == "win32", reason="the simulated stage needs a pty")
def test_over_sockets_a_release_and_a_position_are_recorded_as_on_the_virtual_clock(
    tmp_path: Path,
) -> None:
    with serving(tmp_path, "--world", str(SHIPPED)) as served:
        (tmp_path / "rig" / "protocol.toml").write_text("moisten = false\n" + PROTOCOL)
        path = served.completed()
        assert served.drive_V() == pytest.approx(0.0, abs=0.02)
    with open_session(path) as session:
        assert session.outcome is Outcome.COMPLETED
        assert session.output_state is OutputState.SAFE
        assert [run.counts.lost_samples for run in session.runs] == [0, 0]
        assert_swings(session)
    assert labrig("analyze", path) == 0
    release, contact = load_measurements(path).series
    assert release.force_N is None
    assert contact.force_N is not None
    assert np.ptp(contact.force_N) == pytest.approx(2.9e-3, abs=0.4e-3)
    assert contact.current_A is not None
    assert np.ptp(contact.current_A) > 30e-3


def assert_swings(session: RecordedSession) -> None:
    """Its release has all frames: the sheet rests, bends, is let go, and swings."""
    (run,) = (one for one in session.runs if one.planned.extra == "release")
    rest, bent, swinging = (step.time_s for step in run.planned.steps)
    assert rest == 0.0
    assert run.frame_count >= 0.8 * 25.0 * run.planned.duration_s
    images = [run.image(row).astype(int) for row in range(run.frame_count)]
    moved = np.array([np.sum(np.abs(b - a) > 60) for a, b in itertools.pairwise(images)])
    times = run.frame_column("time")[1:]
    assert np.all(moved[times < bent] < 50)  # pixels
    assert np.max(moved[(times > bent) & (times < swinging)]) > 500
    assert np.max(moved[times > swinging]) > 500
