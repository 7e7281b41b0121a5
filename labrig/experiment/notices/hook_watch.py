"""Call the hooks for a session whose process was killed.

A small process stands by from the session's begin to its end, where hooks are configured. A
session that ends in any other way than by being killed ends this process first. It acts only after
the output guard, which makes the output safe first, has reported or has had its time.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from labrig.config.hooks import HooksConfig
from labrig.experiment.notices.hooks import Hooks, Log
from labrig.session.reading.guard_report import guard_report_path, read_guard_report

_GUARD_S = 12.0  # the guard has reported by then, if it ever does
_LOOK_S = 0.2
_END_S = 2.0


@dataclass(frozen=True, kw_only=True)
class Watched:
    """What the process that stands by must know."""

    config: dict[str, Any]  # of HooksConfig
    session: str  # file
    is_guarded: bool  # by an output guard
    report: list[int] | None  # what was there before, of an earlier session of this name
    parent: int


class HookWatch:
    """The session's side: a process that stands by until `end`."""

    def __init__(self, config: HooksConfig, session: Path, *, is_guarded: bool) -> None:
        """Start it; OSError when the system does not."""
        watched = Watched(
            config=config.model_dump(mode="json"),
            session=str(session.absolute()),
            is_guarded=is_guarded,
            report=_state_of_report(session),
            parent=os.getpid(),
        )
        self._process = _spawn()
        try:
            assert self._process.stdin is not None  # noqa: S101 - for the type checker
            self._process.stdin.write(json.dumps(asdict(watched)).encode() + b"\n")
            self._process.stdin.flush()
        except OSError:
            self.end()
            raise

    def end(self) -> None:
        """End it: whatever is to be told, the session itself tells. Never raises."""
        with suppress(OSError):  # it has ended by itself
            self._process.kill()
        with suppress(subprocess.TimeoutExpired):  # the system ends it when it can
            self._process.wait(_END_S)
        if self._process.stdin is not None:
            with suppress(OSError):  # what was in it can no longer be sent
                self._process.stdin.close()


@contextmanager
def hooks_of(
    config: HooksConfig | None, session: Path, log: Log, *, is_guarded: bool
) -> Iterator[Hooks]:
    """Yield the hooks of a session; an exception that ends the block is told as 'stopped'.

    So is the end of this process, by one that outlives it. `is_guarded`: by the output guard.
    """
    hooks = Hooks(config, session.name, log)
    with _watched(config, session, log, is_guarded=is_guarded):
        try:
            yield hooks
        except BaseException as error:
            hooks.ended(completed=False, text=str(error) or type(error).__name__)
            raise


@contextmanager
def _watched(
    config: HooksConfig | None, session: Path, log: Log, *, is_guarded: bool
) -> Iterator[None]:
    if config is None or not (config.command or config.webhook):
        yield
        return
    try:
        watch = HookWatch(config, session, is_guarded=is_guarded)
    except OSError as error:
        log(f"[hooks] nobody will be told if this program is killed: {error}")
        yield
        return
    try:
        yield
    finally:
        watch.end()


def _spawn() -> subprocess.Popen[bytes]:
    """In a session of its own: what ends the run's whole group must not end it."""
    flags = 0
    if sys.platform == "win32":
        flags = subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW
    root = str(Path(__file__).resolve().parents[2])
    path = os.pathsep.join(filter(None, [root, os.environ.get("PYTHONPATH")]))
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "labrig.experiment.notices.hook_watch"],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": path},
        start_new_session=sys.platform != "win32",
        creationflags=flags,
    )


def main() -> None:
    """Stand by; tell the hooks once the session's process has been killed."""
    order = sys.stdin.readline()
    if not order.endswith("\n"):
        return  # killed while it started this: there is no session yet
    watched = Watched(**json.loads(order))
    _wait_for_death_of(watched.parent)
    session = Path(watched.session)
    text = "the program that ran it was killed"
    if watched.is_guarded:
        text = f"{text}; {_of_the_guard(session, watched.report)}"
    hooks = Hooks(HooksConfig(**watched.config), session.name, _complain)
    hooks.ended(completed=False, text=f"{text}. Run labrig recover on the session")
    hooks.close()


def _wait_for_death_of(parent: int) -> None:
    """Wait until the session's process is gone: it ends us when it ends in any other way."""
    listening = threading.Thread(target=sys.stdin.read, daemon=True)
    listening.start()
    while listening.is_alive():
        listening.join(_LOOK_S)
        # a child that it forked may hold the pipe open
        if sys.platform != "win32" and os.getppid() != parent:
            return


def _state_of_report(session: Path) -> list[int] | None:
    """Return what changes when a report is written; None: there is none.

    Its time need not be later: the computer's clock may be set back during a run.
    """
    try:
        state = guard_report_path(session).stat()
    except OSError:
        return None
    return [state.st_ino, state.st_mtime_ns, state.st_size]


def _of_the_guard(session: Path, before: list[int] | None) -> str:
    """Return what the guard found, once it has made the output safe, or has given up."""
    until_s = time.monotonic() + _GUARD_S
    while time.monotonic() < until_s:
        report = read_guard_report(session)
        if report is not None and _state_of_report(session) != before:
            return report.text
        time.sleep(_LOOK_S)  # noqa: TID251 - no rig is here, and no clock of one
    return "no output guard has reported: look whether the output is at 0 V"


def _complain(text: str) -> None:
    sys.stderr.write(f"labrig: {text}\n")


if __name__ == "__main__":
    main()
    os._exit(0)  # the thread that still reads holds the lock of standard input
