"""A rig whose board puts out each run by the clock of its inputs: edges, faults, and its death."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

import numpy as np
import pytest

from labrig.session import open_session
from protocols.execution.events import OutputState
from tests.end_to_end.faulty_rig import FaultyRig, spied_writes
from tests.end_to_end.real_rig import ServedRig, serving
from tests.end_to_end.small_rig import ONE_POSITION, labrig, make_rig, run_rig

pytestmark = pytest.mark.slow

BOARD = """
[boards]
Dev1 = "{model}"

[wiring]
drive = "Dev1/ao0"
force = "Dev1/ai0"
current = "Dev1/ai1"
readback = "Dev1/ai2"
"""
MODEL = "PCIe-6363"
WIRED = (("PCI6703/", "Dev1/"), ("PCI6034E/", "Dev1/"))
ON_DEMAND = (("[ni]", "[ni]\ntimed_output = false"),)
DONE, FAILED, UNKNOWN = 0, 5, 6
THOROUGH = pytest.mark.thorough
LIMIT_V = 0.25
LAG_SAMPLES = 1  # of the simulated amplifier: its time constant is 1 ms


def samples_off(session_path: Path) -> np.ndarray:
    """How many samples after its recorded index each edge is seen on the read-back."""
    off = []
    with open_session(session_path) as session:
        for run in session.runs:
            drive_V, before_V = run.signal_V("drive"), 0.0
            for row in run.writes:
                sheet_V, index = float(row["sheet_V"]), float(row["sample_index"])
                if sheet_V != before_V:
                    first = int(index) - 50
                    beyond = drive_V[first : first + 100] - (sheet_V + before_V) / 2
                    there = np.sign(beyond) == np.sign(sheet_V - before_V)
                    off.append(first + int(np.flatnonzero(there)[0]) - index)
                before_V = sheet_V
    return np.array(off)


def run_of(folder: Path, model: str, *more: tuple[str, str]) -> Path:
    """The session of a rig with one board, whose clock is 1000 ppm slower than the computer's."""
    world = "board_clock_ppm = -1000.0\n" + BOARD.format(model=model)
    make_rig(folder, ONE_POSITION + 'mode = "paper"\n', world=world)
    text = (folder / "rig.toml").read_text()
    for old, new in (*WIRED, *more):
        assert old in text
        text = text.replace(old, new)
    (folder / "rig.toml").write_text(text)
    return run_rig(folder)


@pytest.fixture(scope="module")
def timed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run_of(tmp_path_factory.mktemp("timed") / "rig", "USB-6211")


def test_an_edge_is_the_sample_that_is_recorded_however_the_clocks_differ(timed: Path) -> None:
    assert np.abs(samples_off(timed) - LAG_SAMPLES).max() < 1e-6
    with open_session(timed) as session:
        (run,) = session.runs
        assert run.readings["valid"].all()
        assert np.abs(run.writes["lateness_s"]).max() < 1e-9
        steps = np.diff(run.writes["sample_index"]) / 1000.0  # [ni] sample_rate_hz
        np.testing.assert_allclose(steps, np.diff(run.writes["planned_s"]), atol=1e-9)


@pytest.mark.thorough
def test_a_replay_has_the_same_samples_and_edges(timed: Path, tmp_path: Path) -> None:
    assert labrig("replay", timed, "-o", tmp_path / "again.h5") == 0
    with open_session(timed) as first, open_session(tmp_path / "again.h5") as again:
        for name in ("drive", "force"):
            there, here = first.runs[0].signal_V(name), again.runs[0].signal_V(name)
            np.testing.assert_array_equal(there, here[: len(there)])  # a slow clock has fewer
        np.testing.assert_allclose(
            first.runs[0].writes["sample_index"], again.runs[0].writes["sample_index"], atol=1e-6
        )


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("[ni]", "[ni]\ntimed_output = false"),
        # A run that takes longer than the guard may allow is not left to the board either.
        ("time_under_voltage_s = 30.0", "time_under_voltage_s = 4.0"),
    ],
)
@pytest.mark.thorough
def test_edges_that_are_written_drift_away_from_the_samples(
    tmp_path: Path, old: str, new: str
) -> None:
    assert np.ptp(samples_off(run_of(tmp_path / "rig", MODEL, (old, new)))) > 1.0


@pytest.fixture
def rig(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> FaultyRig:
    return FaultyRig(tmp_path, capsys, spied_writes(monkeypatch))


@pytest.mark.parametrize(
    ("what", "when", "code", "said"),
    [
        ("output_underflow", "from_s = 0.5", FAILED, "NI-DAQmx -200621"),
        ("daq_slow", "from_s = 0.5", DONE, "completed"),
        pytest.param(
            "daq_refused", "from_s = 0.5\nuntil_s = 0.8", FAILED, "no connection", marks=THOROUGH
        ),
        ("daq_hung", "from_s = 0.5\nuntil_s = 6.0", FAILED, "did not answer"),
        ("daq_hung", "from_s = 0.5", UNKNOWN, "switch the amplifier off by hand"),
        pytest.param(
            "daq_write_refused",
            "from_s = 0.5",
            UNKNOWN,
            "switch the amplifier off by hand",
            marks=THOROUGH,
        ),
        pytest.param(
            "daq_buffer_overflow",
            "from_s = 0.5\nuntil_s = 0.8",
            FAILED,
            "samples were overwritten",
            marks=THOROUGH,
        ),
        pytest.param(
            "output_stuck", "from_s = 0.5", UNKNOWN, "the drive voltage reads", marks=THOROUGH
        ),
        pytest.param(
            "force_nan",
            "from_s = 0.5",
            FAILED,
            "the force input delivers no numbers",
            marks=THOROUGH,
        ),
    ],
)
def test_a_fault_of_the_board_ends_at_0_V_or_is_said_not_to(
    rig: FaultyRig, what: str, when: str, code: int, said: str
) -> None:
    fault = f'[[faults]]\nwhat = "{what}"\nsince = "first_voltage"\n{when}\n'
    left = rig.run(BOARD.format(model=MODEL) + fault, WIRED)
    assert left.code == code, left.said
    assert said in left.said
    assert "Traceback" not in left.said
    assert left.highest_V <= LIMIT_V
    assert left.output is (OutputState.UNKNOWN if code == UNKNOWN else OutputState.SAFE)
    if code != UNKNOWN or what == "daq_hung":  # the board comes to the end of its buffer
        assert left.board_V == 0.0
    if code == DONE:
        assert not left.invalid  # edges are not late, however slow the calls are


@pytest.mark.alone
@pytest.mark.skipif(sys.platform != "linux", reason="needs ptys, signals and /proc")
@pytest.mark.parametrize(
    ("number", "limit_s", "ownership"),
    [
        pytest.param(signal.SIGKILL, 0.3, (), marks=THOROUGH),
        (signal.SIGSTOP, 1.0, ("--strict-ownership",)),
    ],
    ids=["killed", "hung, strict ownership"],
)
def test_the_guard_ends_a_run_that_the_board_would_go_on_with(
    tmp_path: Path, number: int, limit_s: float, ownership: tuple[str, ...]
) -> None:
    with serving(tmp_path, *ownership, world=BOARD.format(model=MODEL)) as rig:
        file = rig.folder / "rig" / "rig.toml"
        text = file.read_text()
        for old, new in WIRED:
            text = text.replace(old, new)
        file.write_text(text)
        process = rig.energised()
        zero_s = _zero_after(rig, process.pid, number)
        process.kill()
        process.wait(5)
    assert zero_s < limit_s + 0.02  # between two rows of the world's record


def _zero_after(rig: ServedRig, pid: int, number: int) -> float:
    """Send a signal; seconds until the sheet was at 0 V, and it stays there."""
    os.kill(pid, number)
    sent_s = float(rig.rows()[-1]["time_s"])
    rig.until(lambda: not rig.is_energised() and float(rig.rows()[-1]["time_s"]) > sent_s, 3.0)
    rig.until(lambda: "safe" in rig.said() or number == signal.SIGSTOP, 5.0)
    live = [float(r["time_s"]) for r in rig.rows() if abs(float(r["drive_V"])) > 1.0]
    return max(live) - sent_s
