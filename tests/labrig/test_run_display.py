"""What `labrig run` says while a run goes on."""

from __future__ import annotations

import errno
import io
import os
import sys

import pytest

from labrig.cli.follow import RunDisplay
from labrig.cli.main import run
from labrig.cli.screen import progress, warn
from labrig.testing.fake_rig import FakeRig, short_schedule
from protocols.execution.events import Event, RunStopped, VoltageSet
from protocols.execution.stop import StopLevel

AT_ONCE = "0 V COULD NOT BE WRITTEN: switch the amplifier off by hand (the run was broken off: "


def said_while(rig: FakeRig, capsys: pytest.CaptureFixture[str]) -> str:
    """Run; what has been said when the run is over, and making safe has not begun."""
    schedule = short_schedule(0.0)
    display = RunDisplay(schedule, lambda _fraction, _text, **_last: None, rig.stop)
    said: list[str] = []

    def show(event: Event) -> None:
        rig.events.append(event)
        display(event)
        if isinstance(event, RunStopped):
            said.append(capsys.readouterr().err)

    rig.scheduler(emit=show).run(schedule)
    return said[0]


def test_a_voltage_that_cannot_be_taken_back_is_told_before_making_safe_begins(
    capsys: pytest.CaptureFixture[str],
) -> None:
    rig = FakeRig()
    rig.faults["output"].fail_at = lambda index: index >= 4
    assert said_while(rig, capsys).count(AT_ONCE) == 1
    assert rig.of_kind(VoltageSet)[-1].write.sheet_V != 0.0


def test_nothing_of_the_kind_is_told_of_a_run_that_ends_at_0_V(
    capsys: pytest.CaptureFixture[str],
) -> None:
    rig = FakeRig()
    rig.faults["signals"].fail_at = lambda index: index == 9
    assert AT_ONCE not in said_while(rig, capsys)
    assert "0 V" not in capsys.readouterr().err


def test_who_stops_after_the_pulse_is_told_that_it_is_understood_and_how_to_stop_at_once(
    capsys: pytest.CaptureFixture[str],
) -> None:
    rig = FakeRig()
    ctrl_c = lambda: rig.stop.request(StopLevel.AFTER_PULSE, "stopped by Ctrl-C")  # noqa: E731
    rig.clock.at.append((rig.clock.now() + 2.0, ctrl_c))
    assert said_while(rig, capsys).count("stopping after this pulse; Ctrl-C once more") == 1


class Closed(io.StringIO):
    """A terminal whose window somebody has closed, or a pipe whose reader has ended."""

    def __init__(self, error: int) -> None:
        super().__init__()
        self._error = error

    def isatty(self) -> bool:
        return self._error == errno.EIO

    def write(self, _text: str) -> int:
        raise OSError(self._error, os.strerror(self._error))


@pytest.mark.parametrize("error", [errno.EIO, errno.EPIPE], ids=["terminal", "pipe"])
def test_a_closed_terminal_or_pipe_does_not_change_how_a_command_ends(
    monkeypatch: pytest.MonkeyPatch, error: int
) -> None:
    monkeypatch.setattr(sys, "stderr", Closed(error))
    monkeypatch.setenv("TERM", "xterm")
    with progress("session") as advance:
        advance(0.5, "")
        warn("a question")
    assert run(["effects", "show", "nothing-of-the-kind"]) == 2


def test_a_line_that_is_said_beside_a_bar_stands_above_it(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = io.StringIO()
    terminal.isatty = lambda: True  # type: ignore[method-assign]
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    with progress("session") as advance:
        advance(0.5, "")
        warn("Mount the sheet.")
    before = terminal.getvalue().partition("Mount the sheet.")[0]
    assert "session" in before
    assert before.endswith("\x1b[2K")  # the bar's line is empty again
    warn("It is over.")
    assert terminal.getvalue().endswith("It is over.\n")


def test_the_progress_line_ends_with_the_output_as_it_was_read_back() -> None:
    """The last line once said 'output energised' of a session that had been stopped at 0 V."""
    rig = FakeRig()
    schedule = short_schedule(0.0)
    lines: list[str] = []
    display = RunDisplay(schedule, lambda _fraction, text, **_last: lines.append(text), rig.stop)
    stop = lambda: rig.stop.request(StopLevel.NOW, "stopped by Ctrl-C")  # noqa: E731
    rig.clock.at.append((rig.clock.now() + 9.2, stop))
    rig.scheduler(emit=display).run(schedule)
    assert "output energised" in " ".join(lines)
    assert lines[-1].startswith("aborted in run 1 of ")
    assert lines[-1].endswith("output safe, read back")


@pytest.mark.parametrize("runs", [1, 2])
def test_the_end_of_a_session_says_which_runs_have_lost_readings(
    capsys: pytest.CaptureFixture[str], runs: int
) -> None:
    """Of the first run it was said long before, and a person looks at the last lines."""
    rig = FakeRig()
    schedule = short_schedule(0.0, 0.01)
    began_s = rig.clock.now()
    rig.camera.lost = lambda time_s: runs == 2 or time_s - began_s < 10.0
    lines: list[str] = []

    def advance(_fraction: float, _text: str, *, last: bool = False) -> None:
        if last:
            lines.extend(capsys.readouterr().err.splitlines())

    display = RunDisplay(schedule, advance, rig.stop)
    rig.scheduler(emit=display).run(schedule)
    *_, heading = (i for i, line in enumerate(lines) if line == "warning: readings were lost:")
    told = lines[heading + 1 :]
    assert [line.split(":")[0] for line in told] == [f"  run {i + 1}" for i in range(runs)]
    assert all("readings do not count" in line for line in told)


def test_a_pipe_gets_the_end_of_a_session_as_a_line_of_its_own(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with progress("session") as advance:
        advance(0.41, "output energised")
        advance(0.42, "aborted · output safe")
        advance(0.42, "aborted · output safe", last=True)
    said = capsys.readouterr().err.splitlines()
    assert said == ["session: 40 % - output energised", "session: 42 % - aborted · output safe"]
