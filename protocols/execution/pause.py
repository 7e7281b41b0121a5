"""A pause between two runs: asked for at any time, kept at 0 V, read back."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from protocols.execution.output import MadeSafe
from protocols.execution.stop import StopLevel, StopRequest

_POLL_S = 0.1


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
