"""Asking a session to stop, from any thread or signal handler."""

from __future__ import annotations

from enum import IntEnum


class StopLevel(IntEnum):
    """How soon."""

    NONE = 0
    AFTER_PULSE = 1  # when the present pulse and its reading are over; at once at 0 V
    NOW = 2  # 0 V as soon as the loop notices, within some 50 ms


class StopRequest:
    """A request that can be made more urgent but not taken back.

    It holds no lock: signal handlers may call `request` at any moment, also while another call is
    under way. Both facts are set by one assignment.
    """

    def __init__(self) -> None:
        self._asked: tuple[StopLevel, str] = (StopLevel.NONE, "")

    def request(self, level: StopLevel, why: str) -> None:
        """Ask for a stop; `why` goes into the session's reason."""
        if level > self._asked[0]:
            self._asked = (level, why)

    @property
    def level(self) -> StopLevel:
        """The most urgent request so far."""
        return self._asked[0]

    @property
    def why(self) -> str:
        """The reason given with it."""
        return self._asked[1]
