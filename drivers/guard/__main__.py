"""The guard's process: read the settings, connect, watch, act at most once, end."""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import signal
import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from drivers.boards.ni.connection import NiConnection
from drivers.boards.ni.take_over import take_over
from drivers.guard.settings import ALIVE, FAILED, READY, REPORT, GuardSettings
from drivers.guard.watch import Ending, ParentWatchdog, parent_watch, words_of
from drivers.interfaces import DeviceError, RealClock
from drivers.safe_shutdown import SafetyReport

_PERSIST_S = 8.0  # with boards that refuse, or do not answer
_BETWEEN_TRIES_S = 0.2
_PATIENCE_S = 3.0
_SAFE_CODE, _FAILED_CODE, _UNKNOWN_CODE = 0, 3, 6


def main() -> int:
    """Run the guard; the exit code says whether the output is safe (0), or not known to be (6)."""
    _ignore_signals()
    clock = RealClock()
    connection: NiConnection | None = None
    try:
        settings = GuardSettings.from_json(_first_line())
        connection = NiConnection(settings.place.address)
        connection.open()
        _warm_up()
    except DeviceError as fault:
        _say(FAILED, str(fault))
        return _FAILED_CODE
    lives = parent_watch(settings.program_pid)
    _say(READY)
    ending = ParentWatchdog(settings, clock, words_of(0), lambda: _say(ALIVE), lives).until_end()
    if ending is Ending.DISARMED:
        connection.close()
        return _SAFE_CODE

    def end_the_program() -> None:
        """Where tasks belong to their process, only its end makes the driver release them."""
        if _is_in_the_way(ending, lives):
            _kill(settings.program_pid)

    report = _act(settings, connection, clock, end_the_program)
    _tell_everybody(settings, ending, report)
    return _SAFE_CODE if report.is_safe else _UNKNOWN_CODE


def _act(
    settings: GuardSettings,
    connection: NiConnection,
    clock: RealClock,
    on_held: Callable[[], None],
) -> SafetyReport:
    """Take the output over; again, on a new connection, when that did not end in 0 V."""
    until_s = clock.now() + _PERSIST_S
    report = take_over(connection, clock, settings.place, _PATIENCE_S, on_held)
    while not report.is_safe and clock.now() < until_s:
        connection.close()
        clock.sleep_until(clock.now() + _BETWEEN_TRIES_S)
        with contextlib.suppress(DeviceError):
            connection.open()
        report = take_over(connection, clock, settings.place, _PATIENCE_S, on_held)
    connection.close()
    return report


def _tell_everybody(settings: GuardSettings, ending: Ending, report: SafetyReport) -> None:
    facts = {"why": ending.value, **asdict(report)}
    _say(REPORT, json.dumps(facts))
    with contextlib.suppress(OSError):
        sys.stderr.write(f"labrig's output guard: {ending.value}; {report.text}\n")
        sys.stderr.flush()
    if settings.report_path is not None:
        with contextlib.suppress(OSError):
            Path(settings.report_path).write_text(json.dumps(facts), encoding="utf-8")


def _first_line() -> str:
    """The settings; byte by byte, since what follows belongs to the watch."""
    line = bytearray()
    while not line.endswith(b"\n"):
        byte = os.read(0, 1)
        if not byte:
            break
        line += byte
    return line.decode("utf-8", errors="replace")


def _say(word: str, rest: str = "") -> None:
    """A line to the program, which may be gone."""
    with contextlib.suppress(OSError, ValueError):
        sys.stdout.write(f"{word} {rest}".strip() + "\n")
        sys.stdout.flush()


def _warm_up() -> None:
    """Load what acting needs: then is no time for it."""
    for module in ("nidaqmx.constants", "nidaqmx.stream_readers"):
        importlib.import_module(module)


def _ignore_signals() -> None:
    """The guard ends when the program does, and by nothing that is meant for the program."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK"):
        number = getattr(signal, name, None)
        if number is not None:
            signal.signal(number, signal.SIG_IGN)


def _is_in_the_way(ending: Ending, lives: Callable[[], bool]) -> bool:
    """Whether the program still holds its tasks and will not let go by itself."""
    if ending is Ending.ASKED:
        return False
    if sys.platform == "win32":  # where its number may have a new owner, once it has died
        return ending is not Ending.GONE
    return lives()


def _kill(program_pid: int) -> None:
    """End the program that hangs, so that the driver releases its tasks."""
    with contextlib.suppress(OSError):
        os.kill(program_pid, getattr(signal, "SIGKILL", signal.SIGTERM))


if __name__ == "__main__":
    code = main()
    # A program that hangs may not read our last words: do not wait for it at exit.
    os._exit(code)
