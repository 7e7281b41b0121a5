"""`labrig replay` of a session that was not completed: only what was recorded is played."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import labrig
from labrig.errors import ExitCode
from labrig.session import open_session, verify
from protocols.execution.events import Outcome, ReadingTaken, RunStarted, RunStopped, SignalsArrived
from protocols.execution.stop import StopLevel, StopRequest
from tests.end_to_end.small_rig import OVERLOADED_IN_THE_SECOND_RUN, make_rig
from tests.end_to_end.small_rig import labrig as command

pytestmark = pytest.mark.slow
FILES = ("rig.toml", "protocol.toml", "sheet.toml")
PROTOCOL = """
[pulse_train]
zero_readings = 1
readings_per_voltage = 2
[[places]]
configuration = "long"
positions_mm = [10, 15, 20]
[extras]
mode = "paper"
"""
RELEASE = """
[pulse_train]
zero_readings = 1
readings_per_voltage = 1
[[places]]
configuration = "long"
positions_mm = [5]
[extras]
reversed_approach = false
no_touch_zero = false
[extras.release]
rest_s = 0.2
hold_s = 0.3
swing_s = 0.5
"""
REASON = "stopped by the test"


def stopped_session(folder: Path, when: str) -> Path:
    """Record a session that is stopped in its second run, or after its first one."""
    stop = StopRequest()

    def on_event(event: object) -> None:
        amid = isinstance(event, ReadingTaken) and (event.run, event.planned.index) == (1, 2)
        if amid if when == "amid" else isinstance(event, RunStopped):
            stop.request(StopLevel.AFTER_PULSE, REASON)

    make_rig(folder, PROTOCOL, OVERLOADED_IN_THE_SECOND_RUN if when == "fault" else "")
    files = [folder / name for name in FILES]
    if when == "fault":
        labrig.run(*files, folder / "session.h5")
    else:
        labrig.run(*files, folder / "session.h5", on_event=on_event, stop=stop)
    return folder / "session.h5"


@pytest.fixture(
    scope="module",
    params=[
        "amid",
        "fault",
        pytest.param("between", marks=pytest.mark.thorough),
    ],
)
def original(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return stopped_session(tmp_path_factory.mktemp(request.param) / "rig", request.param)


@pytest.fixture(scope="module")
def replayed(original: Path) -> Path:
    path = original.with_name("replayed.h5")
    assert command("replay", original, "-o", path) == code_of(original)
    return path


def code_of(original: Path) -> ExitCode:
    """The exit code with which the recorded session ended."""
    with open_session(original) as session:
        return ExitCode.FAILED if session.outcome is Outcome.FAILED else ExitCode.STOPPED


def test_only_what_was_recorded_is_played(original: Path, replayed: Path) -> None:
    with open_session(original) as first, open_session(replayed) as again:
        assert any(run.started for run in first.runs)
        assert not all(run.started for run in first.runs)
        assert [run.started for run in again.runs] == [run.started for run in first.runs]
        assert [run.completed for run in again.runs] == [run.completed for run in first.runs]
        for run, its in zip(first.runs, again.runs, strict=True):
            for column in ("index", "voltage_V", "force_N", "valid"):
                np.testing.assert_array_equal(its.readings[column], run.readings[column])


def test_it_ends_as_the_original_did(original: Path, replayed: Path) -> None:
    with open_session(original) as first, open_session(replayed) as again:
        assert again.outcome is first.outcome
        how = "failed" if first.outcome is Outcome.FAILED else "was aborted"
        said = f"the recording of session.h5 ends here; that session {how}: {first.reason}"
        assert again.reason == said
    assert all(check.ok for check in verify(replayed))


def test_the_last_line_says_where_the_recording_ends(
    original: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code = code_of(original)
    assert command("replay", original) == code
    told = capsys.readouterr().err
    outcome = "failed" if code is ExitCode.FAILED else "aborted"
    assert f"{original}: {outcome}: the recording of session.h5 ends here; that session " in told
    assert "readings do not count" not in told or "overload" in told


@pytest.mark.thorough
def test_a_run_without_readings_ends_with_its_samples(tmp_path: Path) -> None:
    stop, release = StopRequest(), []

    def on_event(event: object) -> None:
        if isinstance(event, RunStarted) and event.run.extra == "release":
            release.append(event.run.index)
        elif isinstance(event, SignalsArrived) and event.run in release:
            stop.request(StopLevel.NOW, REASON)

    make_rig(tmp_path, RELEASE)
    original, replayed = tmp_path / "session.h5", tmp_path / "replayed.h5"
    labrig.run(*(tmp_path / name for name in FILES), original, on_event=on_event, stop=stop)
    assert command("replay", original, "-o", replayed) == ExitCode.STOPPED
    with open_session(original) as first, open_session(replayed) as again:
        (run, its) = (session.run(release[0]) for session in (first, again))
        assert (its.started, its.completed) == (run.started, run.completed) == (True, False)
        assert [one.started for one in again.runs] == [one.started for one in first.runs]
        assert run.samples <= its.samples < run.samples + 0.2 * first.rate_hz
        np.testing.assert_array_equal(its.signal_V("force")[: run.samples], run.signal_V("force"))
