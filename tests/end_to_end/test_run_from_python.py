"""`labrig.run` in a script or a notebook."""

from __future__ import annotations

import os
import signal
import threading

import pytest

import labrig
from labrig.errors import BadInputError, ExitCode
from protocols.execution.events import Outcome, ReadingTaken
from tests.end_to_end.small_rig import ONE_POSITION, make_rig

FILES = ("rig.toml", "protocol.toml", "sheet.toml")


@pytest.fixture
def rig(tmp_path):
    make_rig(tmp_path, ONE_POSITION)
    return [str(tmp_path / name) for name in FILES]


@pytest.mark.thorough
@pytest.mark.slow
def test_a_run_is_recorded_and_its_events_are_followed(rig, tmp_path):
    seen = []
    result = labrig.run(*rig, str(tmp_path / "session.h5"), on_event=seen.append)
    assert result.outcome is Outcome.COMPLETED
    assert result.code == ExitCode.DONE
    assert "the output is at 0 V, read back" in result.text
    with labrig.open_session(result.path) as recorded:
        assert recorded.outcome is Outcome.COMPLETED
        taken = sum(len(run.readings) for run in recorded.runs)
    assert sum(isinstance(event, ReadingTaken) for event in seen) == taken


@pytest.mark.slow
def test_ctrl_c_stops_after_the_pulse_and_leaves_the_output_safe(rig, tmp_path):
    def once(event):
        if isinstance(event, ReadingTaken) and not stopped:
            stopped.append(event)
            os.kill(os.getpid(), signal.SIGINT)

    stopped = []
    before = signal.getsignal(signal.SIGINT)
    result = labrig.run(*rig, tmp_path / "session.h5", on_event=once)
    assert result.outcome is Outcome.ABORTED
    assert result.code == ExitCode.STOPPED
    assert "0 V, read back" in result.text
    assert repr(result).replace("\n", " ") == f"{result.path}: {result.text}"
    assert max(map(len, repr(result).splitlines())) <= max(100, len(str(result.path)) + 1)
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.thorough
def test_a_run_in_another_thread_needs_no_signals(rig, tmp_path):
    results = []
    session = tmp_path / "session.h5"
    thread = threading.Thread(target=lambda: results.append(labrig.run(*rig, session)))
    thread.start()
    thread.join()
    assert results[0].outcome is Outcome.COMPLETED


def test_a_real_rig_asks_for_an_operator(rig, tmp_path):
    text = (tmp_path / "rig.toml").read_text()
    (tmp_path / "rig.toml").write_text(
        text.replace('address = "simulated"', 'address = "127.0.0.1:9"')
    )
    with pytest.raises(BadInputError, match="give operator=, or yes=True"):
        labrig.run(*rig, tmp_path / "session.h5")
    assert not (tmp_path / "session.h5").exists()
