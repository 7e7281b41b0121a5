"""However a run ends, one function makes the output safe; the last chance is the exit."""

from __future__ import annotations

import atexit
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from drivers.interfaces import DeviceError, DeviceTimeoutError
from drivers.safe_shutdown import Safety, SafetyReport
from labrig.experiment.operator import NoOperator
from labrig.experiment.preflight import plan_of
from labrig.experiment.rig.rig import Rig, opened
from labrig.experiment.rig.wiring import wire
from labrig.experiment.safe_shutdown import SafeShutdown, safe_shutdown
from tests.end_to_end.small_rig import make_rig

SCRIPT = """
import atexit, os, sys
from pathlib import Path
from labrig.experiment.operator import NoOperator
from labrig.experiment.preflight import plan_of
from labrig.experiment.rig.rig import opened
from labrig.experiment.safe_shutdown import safe_shutdown
from labrig.experiment.rig.wiring import wire

rig = wire(plan_of(Path(sys.argv[1])), NoOperator(print))
held = [opened(rig)]
held[0].__enter__()

def look():
    print(f"at the end: {rig.signals.measure(0.02)[2].mean():.1f} V", flush=True)
    os._exit(7)  # what was left open is not to be closed

atexit.register(look)
held.append(safe_shutdown(rig))
held[1].__enter__()
rig.output.write(2.0)
print(f"before: {rig.signals.measure(0.1)[2][-20:].mean():.1f} V")
sys.exit(1)
"""


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    folder = make_rig(tmp_path / "rig")
    with opened(wire(plan_of(folder / "rig.toml"), NoOperator(print))) as rig:
        yield rig


def sheet_V(rig: Rig) -> float:
    rig.clock.sleep_until(rig.clock.now() + 0.05)
    return float(rig.signals.measure(0.02)[2].mean())


class Guarding:
    """A guard that says what it found; by then nobody else may hold the boards."""

    can_act = True

    def __init__(self, rig: Rig, state: Safety) -> None:
        self.rig, self.state = rig, state

    def new_run(self) -> None: ...
    def run_over(self) -> None: ...

    def beat(self) -> None: ...

    def energised(self, on: bool) -> None: ...

    def act(self, _timeout_s: float) -> SafetyReport:
        with pytest.raises(DeviceError, match="not open"):
            self.rig.output.write(0.0)
        return SafetyReport(self.state, 0.0, ("the guard had to wait",))


@pytest.mark.slow
def test_an_interpreter_that_ends_with_the_sheet_energised_makes_it_safe(tmp_path: Path) -> None:
    folder = make_rig(tmp_path / "rig")
    command = [sys.executable, "-c", SCRIPT, str(folder / "rig.toml")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 7, done.stderr
    assert done.stdout.splitlines() == ["before: 2.0 V", "at the end: 0.0 V"]


def test_an_exception_makes_safe_before_it_goes_on(rig: Rig) -> None:
    shutdown = None
    try:
        with safe_shutdown(rig) as shutdown:
            rig.output.write(2.0)
            raise ZeroDivisionError
    except ZeroDivisionError:
        pass
    assert shutdown is not None
    assert shutdown.report is not None
    assert shutdown.report.is_safe
    assert abs(sheet_V(rig)) < 0.05


class Gone(Guarding):
    """A guard that has been killed: it does nothing, and has nothing to report."""

    can_act = False

    def act(self, _timeout_s: float) -> SafetyReport:
        return SafetyReport(Safety.UNKNOWN, None, ("the output guard gave no report",))


@pytest.mark.parametrize("guard", ["none", "killed"])
@pytest.mark.parametrize(("hangs_s", "state"), [(4.5, Safety.SAFE), (1e6, Safety.UNKNOWN)])
def test_without_a_guard_zero_is_tried_until_the_deadline_of_the_shutdown(
    rig: Rig, hangs_s: float, state: Safety, guard: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock, board = rig.clock, rig.output._output
    write, answers_s = board.write, clock.now() + hangs_s

    def hung(board_V: float) -> object:
        clock.sleep_until(min(answers_s, clock.now() + 1.2))  # the deadline of one call
        if clock.now() < answers_s:
            raise DeviceTimeoutError("the server did not answer")
        return write(board_V)

    rig.output.write(2.0)
    monkeypatch.setattr(board, "write", hung)
    began_s = clock.now()
    shutdown, told = SafeShutdown(rig), []
    shutdown.tell = lambda text: told.append((clock.now() - began_s, text))
    if guard == "killed":
        shutdown.watchdog = Gone(rig, state)
    report = shutdown.make_safe()
    assert report.state is state
    assert clock.now() - began_s < 7.0  # and 2 s until that is noticed
    ((after_s, text),) = told
    assert after_s < 1.6  # 0 V failed: before the read-back is tried
    assert "switch the amplifier off by hand; labrig keeps trying" in text
    rig.boards.open()  # where it is unknown they were let go of
    rig.signals.open()
    assert (abs(sheet_V(rig)) < 0.05) is (state is Safety.SAFE)
    monkeypatch.undo()


@pytest.mark.slow
def test_each_shutdown_that_fails_is_told(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_board_V: float) -> None:
        raise DeviceError("the board refuses")

    shutdown, told = SafeShutdown(rig), []
    shutdown.tell = told.append
    for times in (1, 2):
        with monkeypatch.context() as broken:
            broken.setattr(rig.output._output, "write", refuse)
            shutdown.make_safe()
        assert len(told) == times
        rig.boards.open()  # they were let go of
        rig.signals.open()


def test_a_run_that_was_made_safe_is_not_made_safe_again(rig: Rig) -> None:
    with safe_shutdown(rig) as shutdown:
        first = shutdown.make_safe()
    assert shutdown.report is first
    atexit.unregister(shutdown.make_safe)  # it was already: nothing to remove, nothing raised


@pytest.mark.parametrize("state", Safety)
def test_what_the_guard_finds_counts_when_the_program_cannot_do_it(
    rig: Rig, state: Safety, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_board_V: float) -> None:
        raise DeviceError("the board refuses")

    with safe_shutdown(rig) as shutdown:
        shutdown.watchdog = Guarding(rig, state)
        monkeypatch.setattr(rig.output._output, "write", refuse)
        monkeypatch.setattr(rig.output._output, "open", lambda: None)
        real = rig.output.abandon

        def abandon() -> None:
            real()
            monkeypatch.undo()

        monkeypatch.setattr(rig.output, "abandon", abandon)
        report = shutdown.make_safe()
    assert report.state is state
    assert report.failures == ("the board refuses", "the guard had to wait")
