"""`labrig run` as a process on the real clock: over TCP, HTTP and a serial line."""

from __future__ import annotations

import itertools
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from labrig.session import open_session
from protocols.execution.events import Outcome, OutputState
from tests.end_to_end.real_rig import ServedRig, serving
from tests.end_to_end.small_rig import labrig

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform == "win32", reason="the simulated stage needs a pty"),
]
LIMIT_V = 2.5


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedRig]:
    with serving(tmp_path_factory.mktemp("served")) as rig:
        yield rig


@pytest.fixture
def rig(served: ServedRig) -> Iterator[ServedRig]:
    yield served
    served.end()


@pytest.mark.alone
def test_a_run_over_sockets_is_complete_and_never_exceeds_the_limit(rig: ServedRig) -> None:
    process = rig.start()
    assert process.wait(60) == 0
    with open_session(rig.session) as session:
        assert session.outcome is Outcome.COMPLETED
        run = session.runs[0]
        assert len(run.readings) == 15
        assert run.counts.lost_samples == 0
        late_s = run.writes["lateness_s"]
        assert (late_s > -1e-3).all()
        assert set(run.readings["drive_V"].round().tolist()) == {0.0, 2.0, -2.0}
    volts = [abs(float(row["drive_V"])) for row in rig.rows()]
    assert max(volts) < LIMIT_V
    assert rig.drive_V() == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize(
    ("number", "times"),
    [
        (signal.SIGINT, 1),
        pytest.param(signal.SIGINT, 2, marks=pytest.mark.thorough),
        (signal.SIGTERM, 1),
    ],
)
def test_a_stop_signal_ends_at_zero_volts_with_code_4(
    rig: ServedRig, number: signal.Signals, times: int
) -> None:
    process = rig.energised()
    for _ in range(times):
        process.send_signal(number)
    assert process.wait(30) == 4
    assert rig.drive_V() == pytest.approx(0.0, abs=0.02)
    with open_session(rig.session) as session:
        assert session.outcome is Outcome.ABORTED
        assert session.output_state is OutputState.SAFE
        assert "Ctrl-C" in session.reason or "SIGTERM" in session.reason


@pytest.mark.alone
def test_after_a_kill_the_output_is_zero_and_at_most_one_reading_is_missing(
    rig: ServedRig, capsys: pytest.CaptureFixture[str]
) -> None:
    process = rig.start()
    rig.until(lambda: len([r for r in rig.rows() if abs(float(r["drive_V"])) > 1.0]) > 100)
    rig.until(rig.is_energised)
    pulses_before = _edges(rig)
    process.kill()
    process.wait(5)
    killed_s = float(rig.rows()[-1]["time_s"])
    rig.until(lambda: not rig.is_energised(), 2.0)
    zero_s = float(rig.rows()[-1]["time_s"])
    assert zero_s - killed_s < 0.5
    assert labrig("verify", rig.session) == 2
    assert labrig("recover", rig.session, "-o", rig.folder / "whole.h5") == 0
    assert labrig("verify", rig.folder / "whole.h5") == 0
    capsys.readouterr()
    with open_session(rig.folder / "whole.h5") as session:
        assert session.outcome is Outcome.CRASHED
        taken = len(session.runs[0].readings)
    # One zero reading, and one for each pulse but the one under way and the one being taken.
    assert 1 + pulses_before - 2 <= taken <= 1 + pulses_before


def test_safe_writes_zero_volts_from_another_process(rig: ServedRig) -> None:
    assert labrig("safe", rig.folder / "rig" / "rig.toml") == 0
    assert rig.drive_V() == pytest.approx(0.0, abs=0.02)


def test_a_vanished_server_ends_the_run_with_code_6_and_a_whole_session(tmp_path: Path) -> None:
    with serving(tmp_path) as rig:
        process = rig.energised()
    assert process.wait(60) == 6
    assert "Traceback" not in rig.said()
    assert "switch the amplifier off" in rig.said()
    with open_session(rig.session) as session:
        assert session.outcome is Outcome.FAILED
        assert session.output_state is OutputState.UNKNOWN


def _edges(rig: ServedRig) -> int:
    """How many pulses have begun."""
    volts = [float(row["drive_V"]) for row in rig.rows()]
    signs = [0 if abs(v) < 1.0 else (1 if v > 0 else -1) for v in volts]
    return sum(a != b and b != 0 for a, b in itertools.pairwise(signs))
