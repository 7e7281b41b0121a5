"""The guard's process: read the settings, connect, watch, act at most once, end."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
from collections.abc import Callable

from drivers.boards import BOARD_FAMILIES, OutputRescue
from drivers.guard.rescuer import Rescuer
from drivers.guard.settings import ACTING, ALIVE, FAILED, READY, REPORT, GuardSettings
from drivers.guard.suspect import what_hangs
from drivers.guard.watch import Ending, ParentWatchdog, messages_from, parent_watch
from drivers.interfaces import DeviceError, RealClock
from drivers.plugins import UnknownPartError
from drivers.safe_shutdown import SafetyReport, attempt

_ANSWER_S = 1.0  # boards that let the output be made safe within this have answered
_line = 1  # the pipe to the program
_SAFE_CODE, _FAILED_CODE, _UNKNOWN_CODE = 0, 3, 6


def main() -> int:
    """Run the guard; the exit code says whether the output is safe (0), or not known to be (6)."""
    _ignore_signals()
    _keep_the_line()
    clock = RealClock()
    try:
        settings = GuardSettings.from_json(_first_line())
        rescue = _rescue_of(settings, clock)
        rescue.open()
    except DeviceError as fault:
        _send(FAILED, str(fault))
        return _FAILED_CODE
    except Exception as fault:  # noqa: BLE001 - the boards' code may be another distribution's
        _send(FAILED, f"unexpected {type(fault).__name__}: {' '.join(str(fault).split())}")
        return _FAILED_CODE
    lives = parent_watch(settings.program_pid)
    _send(READY)
    watchdog = ParentWatchdog(settings, clock, messages_from(0), lambda: _send(ALIVE), lives)
    ending = watchdog.until_end()
    if ending is Ending.DISARMED:
        attempt([], rescue.close)
        return _SAFE_CODE
    _send(ACTING)
    sign = watchdog.sign

    def end_the_program() -> None:
        """Where tasks belong to their process, only its end makes the driver release them."""
        if _is_in_the_way(ending, lives):
            _kill(settings.program_pid)

    def why(report: SafetyReport, took_s: float) -> str:
        if ending is not Ending.HUNG:
            return ending.value
        answered = report.is_safe and took_s < _ANSWER_S
        return what_hangs(sign, settings.boards, settings.address, boards_answer=answered)

    rescuer = Rescuer(
        settings,
        rescue,
        lambda: _rescue_of(settings, clock),
        clock,
        lambda facts: _send(REPORT, facts),
    )
    report = rescuer.act(end_the_program, why)
    return _SAFE_CODE if report.is_safe else _UNKNOWN_CODE


def _rescue_of(settings: GuardSettings, clock: RealClock) -> OutputRescue:
    """Return what makes these boards safe. Raises DeviceError."""
    try:
        rescue = BOARD_FAMILIES.get(settings.boards).rescue
    except UnknownPartError as fault:
        raise DeviceError(str(fault)) from fault
    if rescue is None:
        raise DeviceError(f"boards of the kind {settings.boards} cannot be made safe from outside")
    return rescue(settings.place, clock)


def _first_line() -> str:
    """Read the settings byte by byte: what follows belongs to the watchdog."""
    line = bytearray()
    while not line.endswith(b"\n"):
        byte = os.read(0, 1)
        if not byte:
            break
        line += byte
    return line.decode("utf-8", errors="replace")


def _keep_the_line() -> None:
    """Keep the pipe to the program for our messages: what a maker's code prints is no message."""
    global _line
    with contextlib.suppress(OSError):  # a program without a standard error
        kept = os.dup(1)
        os.dup2(2, 1)
        _line = kept


def _send(message: str, rest: str = "") -> None:
    """Send a line to the program, which may be gone."""
    with contextlib.suppress(OSError):
        os.write(_line, (f"{message} {rest}".strip() + "\n").encode("utf-8", errors="replace"))


def _ignore_signals() -> None:
    """Ignore what is meant for the program: the guard ends when the program does."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK"):
        number = getattr(signal, name, None)
        if number is not None:
            signal.signal(number, signal.SIG_IGN)


def _is_in_the_way(ending: Ending, lives: Callable[[], bool]) -> bool:
    """Whether the program still holds its tasks and will not let go by itself."""
    if ending is Ending.ASKED:
        return False
    # On Windows its number may have a new owner, once it has died.
    return ending is not Ending.GONE if sys.platform == "win32" else lives()


def _kill(program_pid: int) -> None:
    """End the program that hangs, so that the driver releases its tasks."""
    with contextlib.suppress(OSError):
        os.kill(program_pid, getattr(signal, "SIGKILL", signal.SIGTERM))


if __name__ == "__main__":
    code = main()
    # A program that hangs may not read our last message: do not wait for it at exit.
    os._exit(code)
