"""The guard of `labrig run`: programs that hang, boards that refuse, a run after one that died."""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from labrig.errors import BadInputError
from labrig.session import open_session
from labrig.session.reading.guard_report import read_guard_report
from protocols.execution.events import Outcome, OutputState
from tests.end_to_end.real_rig import ServedRig, children, serving
from tests.end_to_end.small_rig import labrig
from tests.labrig.test_hooks import KEEP, told

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="needs ptys, signals and /proc"),
]
AFTER_A_KILL_S, AFTER_A_HANG_S = 0.3, 1.0
ROW_S = 0.02  # between two rows of the world's record
HUNG = '[[faults]]\nwhat = "daq_hung"\nsince = "first_voltage"\nfrom_s = 1.0\n'
INTERLOCK = '[interlock]\nline = "PCI6703/port0/line0"\n'


def zeroed_after(rig: ServedRig, number: int) -> float:
    """Send labrig a signal while the sheet is energised; seconds until the sheet was at 0 V."""
    process = rig.start()
    rig.until(lambda: len([r for r in rig.rows() if abs(float(r["drive_V"])) > 1.0]) > 50)
    rig.until(rig.is_energised)
    os.kill(process.pid, number)
    sent_s = float(rig.rows()[-1]["time_s"])
    rig.until(lambda: not rig.is_energised(), 3.0)
    zero_s = float(rig.rows()[-1]["time_s"])
    process.kill()
    process.wait(5)
    return zero_s - sent_s


@pytest.fixture(
    scope="module",
    params=[(), pytest.param(("--strict-ownership",), marks=pytest.mark.thorough)],
    ids=["", "strict ownership"],
)
def served(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[ServedRig]:
    with serving(tmp_path_factory.mktemp("served"), *request.param) as rig:
        yield rig


@pytest.mark.alone
@pytest.mark.parametrize(
    ("number", "limit_s"),
    [(signal.SIGKILL, AFTER_A_KILL_S), (signal.SIGSTOP, AFTER_A_HANG_S)],
    ids=["killed", "hung"],
)
def test_the_output_is_at_0_V_in_time_whoever_owns_the_tasks(
    served: ServedRig, number: int, limit_s: float
) -> None:
    assert zeroed_after(served, number) < limit_s + ROW_S
    served.until(lambda: read_guard_report(served.session) is not None, 10.0)
    with pytest.raises(BadInputError, match=r"guard has ended this run .*0 V written and read"):
        open_session(served.session)


@pytest.mark.alone
def test_boards_that_refuse_for_longer_than_the_run_tries_are_made_safe_by_the_guard(
    tmp_path: Path,
) -> None:
    refused = '[[faults]]\nwhat = "daq_write_refused"\nsince = "first_voltage"\n'
    with serving(tmp_path, world=refused + "from_s = 1.0\nuntil_s = 4.0\n") as rig:
        process = rig.start()
        assert process.wait(60) == 5
        assert rig.drive_V() == pytest.approx(0.0, abs=0.02)
        assert "is there by name but does not answer" in rig.said()
        with open_session(rig.session) as session:
            assert session.outcome is Outcome.FAILED
            assert session.output_state is OutputState.SAFE


@pytest.mark.thorough
@pytest.mark.alone
def test_a_server_that_hangs_is_named_and_the_words_agree_with_the_code(tmp_path: Path) -> None:
    """The program did not hang; and what was not known to be safe once was read back at last."""
    with serving(tmp_path, world=f"{HUNG}until_s = 4.0\n") as rig:
        process = rig.energised()
        assert process.wait(90) == 5, rig.said()
        assert rig.drive_V() == pytest.approx(0.0, abs=0.02)
        said = rig.said()
        guard = next((line for line in said.splitlines() if "output guard:" in line), "")
        assert "the program hangs" not in said
        assert "the device server at 127.0.0.1" in guard or not guard
        last = said.splitlines()[-1]
        assert "the output is at 0 V, read back" in last
        assert "NOT KNOWN TO BE SAFE" not in last
        with open_session(rig.session) as session:
            assert session.output_state is OutputState.SAFE
            assert "NOT KNOWN TO BE SAFE" not in session.reason


@pytest.mark.alone
def test_a_server_that_hangs_is_told_in_2_s_and_ends_the_run_with_code_6_in_10_s(
    tmp_path: Path,
) -> None:
    """One deadline for the whole shutdown; the guard goes on, and writes 0 V when it can."""
    with serving(tmp_path, world=f"{HUNG}until_s = 14.0\n") as rig:
        process = rig.energised()
        hangs_s = time.monotonic() + 1.0  # `energised` has seen the first voltage a moment later
        rig.until(lambda: "switch the amplifier off" in rig.said(), 10.0)
        told_s = time.monotonic() - hangs_s
        assert process.wait(60) == 6, rig.said()
        ended_s = time.monotonic() - hangs_s
        assert "NOT KNOWN TO BE SAFE" in rig.said().splitlines()[-1]
        rig.until(lambda: not rig.is_energised(), 30.0)
        rig.until(lambda: "the output is safe: 0 V written and read back" in rig.said(), 10.0)
        with open_session(rig.session) as session:
            assert session.output_state is OutputState.UNKNOWN  # as it ended
    assert told_s < 2.0
    assert ended_s < 10.0


@pytest.mark.thorough
def test_a_server_that_stays_away_ends_with_words_and_code_that_say_so(tmp_path: Path) -> None:
    gone = '[[faults]]\nwhat = "daq_write_refused"\nsince = "first_voltage"\nfrom_s = 1.0\n'
    with serving(tmp_path, world=gone) as rig:
        process = rig.energised()
        assert process.wait(90) == 6
        assert "NOT KNOWN TO BE SAFE" in rig.said().splitlines()[-1]
        assert "0 V, read back" not in rig.said()


def test_a_run_refuses_boards_that_a_dead_one_holds_until_labrig_safe_has_freed_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Program and guard are both killed: the one case in which nobody writes 0 V."""
    with serving(tmp_path, more=INTERLOCK) as rig:
        file = rig.folder / "rig" / "rig.toml"
        process = rig.energised()
        for pid in (*children(process.pid), process.pid):
            os.kill(pid, signal.SIGKILL)
        process.wait(5)
        assert rig.is_energised()
        assert rig.start().wait(60) == 3
        assert "`labrig safe` writes 0 V and frees it" in rig.said()
        assert not rig.session.exists()
        assert labrig("safe", file) == 0
        assert "0 V written and read back" in capsys.readouterr().out
        assert rig.drive_V() == pytest.approx(0.0, abs=0.02)
        again = rig.energised()
        again.terminate()
        assert again.wait(30) == 4


def test_labrig_safe_without_boards_to_speak_to_ends_with_code_6(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    gone = dict.fromkeys(("grpc", "camera", "stage"), "127.0.0.1:9")  # nobody serves there
    rig = ServedRig(tmp_path, gone)
    assert labrig("safe", rig.folder / "rig" / "rig.toml") == 6
    said = capsys.readouterr().err
    assert "switch the amplifier off by hand" in said
    assert "no connection" in said


@pytest.mark.alone
def test_an_interlock_drops_the_supply_when_program_and_guard_are_both_killed(
    tmp_path: Path,
) -> None:
    with serving(tmp_path, world='[interlock]\nline = "port0/line0"\n', more=INTERLOCK) as rig:
        process = rig.energised()
        killed_s = float(rig.rows()[-1]["time_s"])
        for pid in (*children(process.pid), process.pid):
            os.kill(pid, signal.SIGKILL)
        process.wait(5)
        over_s = time.monotonic() + 0.5
        rig.until(lambda: time.monotonic() > over_s)
    rows = [(float(row["time_s"]), float(row["drive_V"])) for row in rig.rows()]
    energised = [time_s for time_s, drive_V in rows if abs(drive_V) > 1.0]
    assert rows[-1][1] == 0.0  # nobody has written it
    assert max(energised) - killed_s < 0.3 + 0.05  # after an edge that came within 50 ms


def test_a_run_that_is_killed_is_told_to_the_hooks_once_its_output_is_at_0_V(
    tmp_path: Path,
) -> None:
    file = tmp_path / "told"
    hook = json.dumps([sys.executable, "-c", KEEP, str(file)])
    with serving(tmp_path, more=f"[hooks]\ncommand = {hook}\n") as rig:
        process = rig.energised()
        rig.until(rig.is_energised)
        os.killpg(process.pid, signal.SIGKILL)
        process.wait(5)
        rig.until(lambda: file.exists() and file.read_text().endswith("\n"), 30.0)
        assert rig.drive_V() == pytest.approx(0.0, abs=0.02)
    (one,) = told(file)
    assert (one["event"], one["session"]) == ("stopped", rig.session.name)
    assert one["text"].startswith("the program that ran it was killed; the output guard has ended")
    assert "0 V written and read back" in one["text"]
