"""What the guard waits for: messages from the program, or their absence."""

from __future__ import annotations

import math
import os
import queue
import threading
from collections.abc import Callable
from enum import StrEnum

from drivers.guard.settings import (
    ACT,
    AT_ZERO,
    DISARM,
    ENERGISED,
    NEW_RUN,
    RUN_OVER,
    GuardSettings,
)
from drivers.guard.suspect import SIGNS
from drivers.interfaces import Clock

_TICK_S = 0.02
_STARVED_S = 0.1  # a tick this late was the computer's fault: the program may be as late
_SIGN_S = 0.3  # a life sign older than this was before the program stood still
_BACKSTOP = 1.02  # of the time under voltage: the program itself comes first


class Ending(StrEnum):
    """Why the watch has ended."""

    DISARMED = "the program has finished"
    GONE = "the program has died"
    HUNG = "the program hangs"
    ASKED = "the program has asked for it"
    TOO_LONG = "the sheet was energised for too long in one run"


class ParentWatchdog:
    """Follows the messages on a pipe. `confirm` is called for each batch of them."""

    def __init__(
        self,
        settings: GuardSettings,
        clock: Clock,
        messages: queue.Queue[bytes],
        confirm: Callable[[], None],
        parent_lives: Callable[[], bool],
        *,
        grace_s: float | None = None,
    ) -> None:
        """`grace_s`: how long to listen after a stall of ours, before silence is judged.

        None: the program is on this computer and may have stood still for as long as we have. Then
        a stall of ours is no silence of its.
        """
        self._settings = settings
        self._clock = clock
        self._messages = messages
        self._confirm = confirm
        self._parent_lives = parent_lives
        self._energised_s: float | None = None  # since when
        self._before_s = 0.0  # time under voltage of this run, before that
        self._in_run = False
        self._heard_s = clock.now()
        self._grace_s = grace_s
        self._listen_until_s = -math.inf
        self._sign: tuple[bytes, float] | None = None  # the newest since the last beat, and when

    @property
    def sign(self) -> bytes | None:
        """The life sign of a program that does not beat; None: it gives none."""
        if self._sign is None or self._clock.now() - self._sign[1] > _SIGN_S:
            return None
        return self._sign[0]

    def until_end(self) -> Ending:
        """Block until the guard must act or may go."""
        ticked_s = self._clock.now()
        while True:
            ending = self._hear()
            if ending is not None:
                return ending
            now = self._clock.now()
            late_s = now - ticked_s - _TICK_S
            if late_s > _STARVED_S:
                self._excuse(now, late_s)
            ticked_s = now
            ending = self._judge(now)
            if ending is not None:
                return ending

    def _excuse(self, now: float, late_s: float) -> None:
        """Take a stall of ours into account; where a grace is given, once in a silence."""
        if self._grace_s is None:
            self._heard_s += late_s
        elif self._is_silent(now) and self._listen_until_s < self._heard_s:
            self._listen_until_s = now + self._grace_s

    def _is_silent(self, now: float) -> bool:
        return now - self._heard_s > self._settings.heartbeat_limit_s

    def _hear(self) -> Ending | None:
        """Take in what has come, waiting a tick for it at most."""
        try:
            batch = self._messages.get(timeout=_TICK_S)
        except queue.Empty:
            return None
        if not batch:
            return Ending.GONE
        now = self._clock.now()
        for number in batch:
            message = bytes([number])
            if message in SIGNS:
                self._sign = (message, now)
                continue
            self._heard_s, self._sign = now, None
            if message == DISARM:
                return Ending.DISARMED
            if message == ACT:
                return Ending.ASKED
            self._count(message)
        self._confirm()
        return None

    def _count(self, message: bytes) -> None:
        """Sum the time under voltage."""
        if message == ENERGISED and self._energised_s is None:
            self._energised_s = self._heard_s
        elif message == AT_ZERO and self._energised_s is not None:
            self._before_s += self._heard_s - self._energised_s
            self._energised_s = None
        elif message == NEW_RUN:
            self._before_s, self._in_run = 0.0, True
        elif message == RUN_OVER:
            self._in_run = False

    def _judge(self, now: float) -> Ending | None:
        if not self._parent_lives():
            return Ending.GONE
        if self._energised_s is None:
            return Ending.HUNG if self._hangs_at_zero(now) else None
        if self._is_silent(now) and now >= self._listen_until_s:
            return Ending.HUNG
        under_s = self._before_s + now - self._energised_s
        if under_s > _BACKSTOP * self._settings.time_under_voltage_s:
            return Ending.TOO_LONG
        return None

    def _hangs_at_zero(self, now: float) -> bool:
        """Whether a run at 0 V is silent: a session that waits for ever would tell nobody."""
        limit_s = self._settings.at_zero_limit_s
        return self._in_run and limit_s is not None and now - self._heard_s > limit_s


def messages_from(pipe: int) -> queue.Queue[bytes]:
    """Return what comes from a pipe, in batches; an empty one is its end. A thread for Windows."""
    messages: queue.Queue[bytes] = queue.Queue()

    def read() -> None:
        while True:
            try:
                batch = os.read(pipe, 4096)
            except OSError:
                batch = b""
            messages.put(batch)
            if not batch:
                return

    threading.Thread(target=read, name="pipe", daemon=True).start()
    return messages


def parent_watch(program_pid: int) -> Callable[[], bool]:
    """Whether the program lives, apart from what the pipe shows (all there is on Windows).

    A process that the program has forked may hold the pipe open after the program's death.
    """
    if os.name == "nt":
        return lambda: True
    return lambda: os.getppid() == program_pid
