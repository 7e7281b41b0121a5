"""Asking a session to stop, from any thread or signal handler, or to pause between two runs."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Protocol

from protocols.execution.output import MadeSafe
from protocols.execution.states import FinishReason

_POLL_S = 0.1
DEAF_S = 3.0  # who has not obeyed a request to stop at once by then waits for a device


class StopLevel(IntEnum):
    """How soon."""

    NONE = 0
    AFTER_PULSE = 1  # when the present pulse and its reading are over; at once at 0 V
    NOW = 2  # 0 V as soon as the loop notices, within some 50 ms


class StopRequest:
    """A request that can be made more urgent but not taken back.

    It holds no lock: signal handlers may call `request` at any moment, also while another call is
    under way. All facts are set by one assignment.
    """

    def __init__(self) -> None:
        self._asked = (StopLevel.NONE, "", FinishReason.STOP_REQUESTED)
        self._is_obeyed = False

    def request(
        self, level: StopLevel, why: str, finish: FinishReason = FinishReason.STOP_REQUESTED
    ) -> None:
        """Ask for a stop; `why` goes into the session's reason.

        `finish`: what the session is recorded to have ended by, where nobody has stopped it.
        """
        if level > self._asked[0]:
            self._asked = (level, why, finish)

    def obey(self) -> None:
        """Note that the safe shutdown has begun."""
        self._is_obeyed = True

    @property
    def is_obeyed(self) -> bool:
        """Whether the safe shutdown has begun, for this reason or another one."""
        return self._is_obeyed

    @property
    def level(self) -> StopLevel:
        """The most urgent request so far."""
        return self._asked[0]

    @property
    def why(self) -> str:
        """The reason given with it."""
        return self._asked[1]

    @property
    def finish(self) -> FinishReason:
        """What the session ends by."""
        return self._asked[2]


class PauseRequest(Protocol):
    """Whether somebody wants the session to pause after the present run."""

    def asked_by(self) -> str:
        """Return who wants it; empty: nobody, or not any more.

        Called between runs, ten times a second during a pause. Does not block, and does not raise.
        """


@dataclass(frozen=True)
class Pause:
    """What the scheduler needs to pause."""

    request: PauseRequest
    confirm_zero: Callable[[], MadeSafe]  # write 0 V and read it back; does not raise


def wait_for_end(request: PauseRequest, stop: StopRequest) -> float:
    """Wait until nobody wants the pause any more, or a stop is asked for; return seconds waited."""
    began_s, never = time.monotonic(), threading.Event()
    while request.asked_by() and stop.level is StopLevel.NONE:
        never.wait(_POLL_S)
    return time.monotonic() - began_s


class SignalledStop:
    """Asks for a stop at each signal: after the pulse at the first Ctrl-C, else at once.

    A device whose code does not return, where no voltage is on and so no guard acts, would keep the
    program for ever. So a signal interrupts it where a stop at once is not obeyed for `DEAF_S`, and
    the next one again, as the 0 V after an interrupt may be the next call that does not return.
    Not during the safe shutdown, which has limits of its own.
    """

    def __init__(self, stop: StopRequest, now: Callable[[], float] = time.monotonic) -> None:
        self._stop = stop
        self._now = now  # s
        self._urgent_s: float | None = None  # since when a stop at once is asked for

    def __call__(self, name: str, count: int) -> None:
        """Take a signal. Raises KeyboardInterrupt."""
        level = StopLevel.AFTER_PULSE if count == 1 and name == "SIGINT" else StopLevel.NOW
        self._stop.request(level, f"stopped by {'Ctrl-C' if name == 'SIGINT' else name}")
        now = self._now()
        if self._urgent_s is None and level is StopLevel.NOW:
            self._urgent_s = now
        deaf = self._urgent_s is not None and now - self._urgent_s >= DEAF_S
        if deaf and not self._stop.is_obeyed:
            self._urgent_s = now
            raise KeyboardInterrupt
