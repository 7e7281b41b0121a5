"""`labrig run` on a LabJack over TCP: killed, hung, cut off, and made safe by the next one."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator

import pytest

from tests.end_to_end.real_rig import ServedRig, children, serving
from tests.end_to_end.small_rig import labrig
from tests.end_to_end.test_guard_of_a_run import (
    AFTER_A_HANG_S,
    AFTER_A_KILL_S,
    ROW_S,
    zeroed_after,
)

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="needs ptys, signals and /proc"),
]
INTERLOCK = '[interlock]\nline = "EIO0"\n'
WATCHDOG_S = 1.0


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedRig]:
    with serving(tmp_path_factory.mktemp("labjack"), board="labjack") as rig:
        yield rig


@pytest.mark.alone
@pytest.mark.parametrize(
    ("number", "limit_s"),
    [
        (signal.SIGKILL, AFTER_A_KILL_S),
        pytest.param(signal.SIGSTOP, AFTER_A_HANG_S, marks=pytest.mark.thorough),
    ],
    ids=["killed", "hung"],
)
def test_the_output_is_at_0_V_in_time(served: ServedRig, number: int, limit_s: float) -> None:
    assert zeroed_after(served, number) < limit_s + ROW_S


@pytest.mark.thorough
@pytest.mark.alone
def test_a_program_that_wakes_after_the_guard_has_acted_stays_at_0_V(served: ServedRig) -> None:
    process = served.energised()
    os.kill(process.pid, signal.SIGSTOP)
    served.until(lambda: not served.is_energised(), 3.0)
    rows = len(served.rows())
    os.kill(process.pid, signal.SIGCONT)
    assert process.wait(30) != 0
    assert all(abs(float(row["drive_V"])) < 0.05 for row in served.rows()[rows:])


@pytest.mark.alone
@pytest.mark.parametrize("then_freed", [False, pytest.param(True, marks=pytest.mark.thorough)])
def test_the_devices_watchdog_drops_the_supply_when_program_and_guard_are_both_killed(
    tmp_path_factory: pytest.TempPathFactory,
    capsys: pytest.CaptureFixture[str],
    *,
    then_freed: bool,
) -> None:
    folder = tmp_path_factory.mktemp("watchdog")
    with serving(folder, world=INTERLOCK, more=INTERLOCK, board="labjack") as rig:
        process = rig.energised()
        killed_s = float(rig.rows()[-1]["time_s"])
        for pid in (*children(process.pid), process.pid):
            os.kill(pid, signal.SIGKILL)
        process.wait(5)
        rig.until(lambda: not rig.is_energised(), 3.0)
        zero_s = float(rig.rows()[-1]["time_s"])
        assert zero_s - killed_s < WATCHDOG_S + 0.1
        if not then_freed:
            return
        assert rig.start().wait(60) == 3
        assert "`labrig safe` writes 0 V and frees it" in rig.said()
        assert labrig("safe", rig.folder / "rig" / "rig.toml") == 0
        assert "0 V written and read back" in capsys.readouterr().out
        again = rig.energised()
        again.terminate()
        assert again.wait(30) == 4
