"""One call of a board at a time, and each failure as a sentence."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from drivers.boards.simple.board import SimpleBoard
from drivers.interfaces import (
    Clock,
    DeviceError,
    DeviceNotFoundError,
    DeviceTimeoutError,
    in_words,
)

_TURN_S = 1.0
_LOOK_S = 0.001


class BoardTurns:
    """A board, open or not, whose calls wait for each other."""

    def __init__(self, board: SimpleBoard, name: str, clock: Clock) -> None:
        """`name`: for sentences, such as acme at 192.0.2.7."""
        self.board, self.name, self.clock = board, name, clock
        self.is_open = False
        self._lock = threading.Lock()

    def open(self) -> None:
        """Take the board, unless it is open."""
        if self.is_open:
            return
        try:
            self.board.open()
        except (Exception, SystemExit) as fault:
            self.close()
            raise DeviceNotFoundError(
                f"no connection to {self.name}: {in_words(fault)}; check its power, its address "
                "and whether another program has it"
            ) from fault
        self.is_open = True

    def close(self) -> None:
        """Let go of the board; does not wait for a call that hangs."""
        self.is_open = False
        with suppress(Exception, SystemExit):
            self.board.close()

    @contextmanager
    def turn(self, doing: str) -> Iterator[SimpleBoard]:
        """Yield the board for one call. Raises DeviceError; waits for another call for 1 s.

        Waits by the clock: a virtual one stands still for a thread that waits by anything else.
        """
        if not self.is_open:
            raise DeviceError(f"{doing} failed: the connection to {self.name} is not open")
        until_s = self.clock.now() + _TURN_S
        while not self._lock.acquire(blocking=False):
            if self.clock.now() >= until_s:
                raise DeviceTimeoutError(
                    f"{doing} failed: {self.name} has not answered an earlier request; check its "
                    "cable"
                )
            self.clock.sleep_until(self.clock.now() + _LOOK_S)
        try:
            yield self.board
        except DeviceError:
            raise
        except (Exception, SystemExit) as fault:
            raise DeviceError(f"{doing} failed: {self.name}: {in_words(fault)}") from fault
        finally:
            self._lock.release()
