"""The program's side of the guard."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import IO

from drivers.guard.settings import (
    ACT,
    ACTING,
    ALIVE,
    AT_ZERO,
    BEAT,
    DISARM,
    ENERGISED,
    FAILED,
    HEARTBEAT_S,
    NEW_RUN,
    READY,
    REPORT,
    RUN_OVER,
    GuardSettings,
)
from drivers.guard.suspect import sign_of
from drivers.interfaces import DeviceError, DeviceTimeoutError, RealClock
from drivers.safe_shutdown import Safety, SafetyReport

START_S = 30.0  # a busy computer imports slowly
ACT_S = 8.0  # the guard reports before that, and goes on where it has not succeeded
_END_S = 5.0
_UNHEARD_S = 1.0  # a guard that has not confirmed a beat for so long does not guard
_BEAT_EVERY_S = 0.4 * HEARTBEAT_S
_BEAT_AT_ZERO_S = 1.0
_SIGN_EVERY_S = 0.1  # while the working loop does not beat
_SIGN_AFTER_S = 3 * HEARTBEAT_S


_LEFT_BEHIND: list[subprocess.Popen[bytes]] = []  # that go on trying when we have ended


class Guard:
    """A running guard. `start` it before the first voltage, `disarm` it after the last."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self._process = process
        self._clock = RealClock()  # processes live in real time
        self._ready = threading.Event()
        self._heard_out = threading.Event()  # it has reported, or ended
        self._failure: str | None = None
        self._report: SafetyReport | None = None
        self._acts = False  # by itself, or asked to
        self._energised = self._in_run = False
        self._last_beat_s = self._confirmed_s = self._clock.now()
        self._unconfirmed = 0
        self._why = ""  # it has acted
        self._loop_thread = threading.get_ident()  # that beats
        self._ended = threading.Event()
        self._reader = threading.Thread(target=self._listen, name="guard", daemon=True)
        self._reader.start()
        threading.Thread(target=self._give_signs, name="guard-signs", daemon=True).start()

    @classmethod
    def start(cls, settings: GuardSettings, timeout_s: float = START_S) -> Guard:
        """Start it and wait until it has its own connection to the boards.

        Raises DeviceError when it cannot guard; then nothing may be energised.
        """
        guard = cls(_spawn())
        try:
            ours = replace(settings, program_pid=os.getpid())
            guard._send(ours.to_json().encode("utf-8") + b"\n")
            if not guard._ready.wait(timeout_s):
                raise DeviceTimeoutError(
                    f"the output guard did not start in {timeout_s:g} s; nothing was energised"
                )
            if guard._failure is not None:
                raise DeviceError(f"the output guard cannot start: {guard._failure}")
        except BaseException:
            guard._end()
            raise
        return guard

    @property
    def alive(self) -> bool:
        """Whether it would act if this program failed now."""
        if self._report is not None or self._failure is not None:
            return False
        if self._process.poll() is not None:
            return False
        waiting = self._energised and self._unconfirmed > 0
        return not (waiting and self._clock.now() - self._confirmed_s > _UNHEARD_S)

    @property
    def can_act(self) -> bool:
        """Whether it is there to make the output safe, or has done so."""
        return self._report is not None or self._process.poll() is None

    @property
    def report(self) -> SafetyReport | None:
        """What it did, when it has acted; then this program's tasks are gone."""
        return self._report

    @property
    def pid(self) -> int:
        """Its process."""
        return self._process.pid

    def beat(self) -> None:
        """Report that the working loop runs; called every 50 ms during a run. Does not block.

        Raises DeviceError when the guard has gone or has acted: the run must stop.
        """
        now = self._clock.now()
        every_s = _BEAT_EVERY_S if self._energised else _BEAT_AT_ZERO_S
        if not (self._energised or self._in_run) or now - self._last_beat_s < every_s:
            return
        self._check()
        self._last_beat_s = now
        self._send_if_heard(BEAT)

    def energised(self, on: bool) -> None:
        """Before the first voltage (True), and after 0 V was written (False).

        Raises DeviceError when the guard is gone and `on`: then nothing may be energised.
        """
        if on:
            self._check()
        if on and not self._energised:
            self._confirmed_s = self._last_beat_s = self._clock.now()
            self._unconfirmed = 0
            self._loop_thread = threading.get_ident()
        self._energised = on
        self._send_if_heard(ENERGISED if on else AT_ZERO)

    def new_run(self) -> None:
        """Begin a run, at 0 V: its time under voltage is counted from 0."""
        self._check()
        self._in_run, self._last_beat_s = True, self._clock.now()
        self._loop_thread = threading.get_ident()
        self._send_if_heard(NEW_RUN)

    def run_over(self) -> None:
        """End a run: nothing beats until the next one, which may wait for a person."""
        self._in_run = False
        self._send_if_heard(RUN_OVER)

    def act(self, timeout_s: float = ACT_S) -> SafetyReport:
        """Let the guard make the output safe, by its own connection, and end. Never raises.

        For a program that could not do it itself. It must have closed what it can: with a local
        driver the guard cannot write while this process holds the output. A guard that has not
        succeeded by the time it reports, or by ours, goes on trying.
        """
        self._energised = False
        with suppress(DeviceError):
            self._send(ACT)
        if not self._heard_out.wait(timeout_s) and self._acts:
            self._leave_behind()
            return SafetyReport(Safety.UNKNOWN, None, ("the output guard still tries",))
        self._end()
        if self._report is not None:
            return self._report
        return SafetyReport(Safety.UNKNOWN, None, ("the output guard gave no report",))

    def disarm(self) -> None:
        """End it. May be called twice, and after it has acted.

        While the sheet still counts as energised nobody has confirmed 0 V: then the guard is not
        let go: it is asked to act (see `report`).
        """
        if self._process in _LEFT_BEHIND:
            return
        if self._energised and self.alive:
            self.act()
            return
        self._energised = False
        with suppress(DeviceError):  # it may have ended by itself
            self._send(DISARM)
        self._end()

    def _check(self) -> None:
        if self.alive:
            return
        if self._report is not None:
            # What is known of the output is said by whoever reads it back after this.
            raise DeviceError(f"the output guard has ended this run ({self._why})")
        raise DeviceError(
            "the output guard has ended or does not answer: the run must stop, since nobody would "
            "write 0 V if this program failed; start it again"
        )

    def _send_if_heard(self, message: bytes) -> None:
        """Send a message, unless the guard does not listen: a full pipe would block."""
        if self._unconfirmed < 1000:
            self._unconfirmed += 1
            self._send(message)

    def _send(self, data: bytes) -> None:
        pipe = self._process.stdin
        try:
            if pipe is None or pipe.closed:
                raise BrokenPipeError("closed")
            pipe.write(data)
            pipe.flush()
        except OSError as fault:
            if self._energised or data not in (AT_ZERO, BEAT, DISARM, ACT, RUN_OVER):
                raise DeviceError(f"the output guard has ended ({fault})") from fault

    def _give_signs(self) -> None:
        """Its thread: where the working loop is, while that does not beat."""
        while not self._ended.wait(_SIGN_EVERY_S):
            silent_s = self._clock.now() - self._last_beat_s
            due_s = _SIGN_AFTER_S if self._energised else 2 * _BEAT_AT_ZERO_S
            if (self._energised or self._in_run) and silent_s > due_s:
                with suppress(DeviceError, ValueError):  # a guard that is gone: the loop notices
                    self._send_if_heard(sign_of(self._loop_thread))

    def _listen(self) -> None:
        """Its thread: what the guard says."""
        pipe = self._process.stdout
        if pipe is None:
            return
        for raw in pipe:
            word, _, rest = raw.decode("utf-8", errors="replace").strip().partition(" ")
            if word == ALIVE:
                self._confirmed_s = self._clock.now()
                self._unconfirmed = 0
            elif word == ACTING:
                self._acts = True
            elif word == REPORT:
                self._why, self._report = json.loads(rest)["why"], report_from_json(rest)
                self._heard_out.set()
            elif word == FAILED:
                self._failure = rest
            if word in (READY, FAILED):
                self._ready.set()
        self._heard_out.set()
        if not self._ready.is_set():
            self._failure = self._failure or "it ended at once"
            self._ready.set()

    def _end(self) -> None:
        """Close the pipes and wait; our own child, so it can be ended when it does not listen.

        One that has reported an output that is not safe goes on trying, and outlives us.
        """
        if self._report is not None and not self._report.is_safe and self._process.poll() is None:
            self._leave_behind()
            return
        self._ended.set()
        _close(self._process.stdin)
        try:
            self._process.wait(_END_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._reader.join(_END_S)
        _close(self._process.stdout)

    def _leave_behind(self) -> None:
        """Let it go on trying after we have ended."""
        self._ended.set()
        _close(self._process.stdin)
        _LEFT_BEHIND.append(self._process)


def report_from_json(text: str) -> SafetyReport:
    """Return the report that the guard has printed."""
    data = json.loads(text)
    return SafetyReport(Safety(data["state"]), data["read_back_V"], tuple(data["failures"]))


def _spawn() -> subprocess.Popen[bytes]:
    """In a session of its own: neither Ctrl-C nor a signal to our group may reach it."""
    detached = 0
    if sys.platform == "win32":
        detached = subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW
    root = str(Path(__file__).resolve().parents[2])
    path = os.pathsep.join(filter(None, [root, os.environ.get("PYTHONPATH")]))
    try:
        return subprocess.Popen(
            [sys.executable, "-P", "-m", "drivers.guard"],  # -P: not a drivers.py of this folder
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": path},
            start_new_session=sys.platform != "win32",
            creationflags=detached,
        )
    except OSError as fault:
        raise DeviceError(f"the output guard cannot be started: {fault}") from fault


def _close(pipe: IO[bytes] | None) -> None:
    if pipe is None:
        return
    with suppress(OSError):  # what was in it can no longer be sent
        pipe.close()
