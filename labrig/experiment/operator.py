"""Ask the operator for work by hand, and wait for the answer."""

from __future__ import annotations

import os
import queue
import sys
import threading
import time
from collections.abc import Callable

from drivers.interfaces import Prompt
from labrig.errors import NotReadyError
from protocols.execution.operator import REPEAT

_SLICE_S = 0.1  # between two looks: on Windows Ctrl-C interrupts no longer wait
_BLOCK_BYTES = 4096
_NO_TERMINAL = (
    "Nobody is at a terminal to answer: the session goes on at once, and the run is not repeated."
)


class TypedLines:
    """Reads below Python's own buffer, in a thread that reads only while a line is wanted.

    A thread that waits in `sys.stdin` itself would hold its lock when the program ends.
    """

    def __init__(self) -> None:
        self._blocks: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        self._reading = False
        self._rest = b""

    def next(self, timeout_s: float | None) -> str | None:
        """Return the next line with its end, "" when input has ended, None after `timeout_s`."""
        number = _descriptor()
        if number is None:
            return sys.stdin.readline()
        until_s = None if timeout_s is None else time.monotonic() + timeout_s
        while b"\n" not in self._rest:
            block = self._block(number, until_s)
            if block is None:
                return None
            if not block:
                break
            self._rest += block
        line, end, self._rest = self._rest.partition(b"\n")
        return (line + end).decode("utf-8", "replace")

    def forget(self) -> None:
        """Forget what came by now: it answers no question that is still to be asked."""
        self._rest = b""
        while not self._blocks.empty():
            self._take()

    def _block(self, number: int, until_s: float | None) -> bytes | None:
        if not self._reading:
            self._reading = True
            threading.Thread(
                target=self._read, args=(number,), name="standard input", daemon=True
            ).start()
        while True:
            try:
                return self._take(_SLICE_S)
            except queue.Empty:
                if until_s is not None and time.monotonic() > until_s:
                    return None

    def _take(self, timeout_s: float = 0.0) -> bytes:
        block = self._blocks.get(timeout=timeout_s)
        self._reading = False
        return block

    def _read(self, number: int) -> None:
        try:
            self._blocks.put(os.read(number, _BLOCK_BYTES))
        except OSError:  # it was closed
            self._blocks.put(b"")


def _descriptor() -> int | None:
    """Return that of standard input; None where it is no file of the system."""
    try:
        return sys.stdin.fileno()
    except (AttributeError, OSError, ValueError):
        return None


def _is_terminal() -> bool:
    """Whether somebody may type; what is in a pipe was written before the question was known."""
    try:
        return sys.stdin.isatty()
    except (AttributeError, ValueError):  # there is none, or it was closed
        return False


TYPED = TypedLines()  # of this process: what one session has not read is the next one's


class ConsoleOperator:
    """The person at the terminal: Enter, it is done; q and Enter, stop the session.

    Ctrl-C while a question stands stops the session, too: nothing is energised then. A question
    that may go unanswered waits as long as it says; without a terminal, not at all.
    """

    def __init__(self, show: Callable[[str], None], typed: TypedLines = TYPED) -> None:
        self._show = show
        self._typed = typed
        self.waiting = False  # the signal handler interrupts the question instead of setting a flag
        self.expired = False  # nobody has answered the last question in its time

    def ask(self, prompt: Prompt) -> bool:
        """See `drivers.interfaces.Operator`."""
        if prompt.kind == REPEAT and not _is_terminal():
            self.expired = True
            self._show(f"{prompt.text} {_NO_TERMINAL}")
            return True
        if prompt.kind == REPEAT:
            self._show(f"{prompt.text} (Enter: go on; r and Enter: again; Ctrl-C: stop)")
        else:
            self._show(f"{prompt.text} Then press Enter (q and Enter: stop the session).")
        answer = self._answer(prompt)
        if answer is None:
            return False
        if prompt.kind == REPEAT:  # who is not there to answer wants nothing repeated
            return answer.strip().lower() not in {"r", "repeat", "again", "y", "yes"}
        if not answer:
            raise NotReadyError(
                "Nobody is there to answer: standard input has ended. Run labrig in a terminal, or "
                "with --yes when whatever it asks for is done already."
            )
        return answer.strip().lower() not in {"q", "quit", "stop", "n", "no"}

    def _answer(self, prompt: Prompt) -> str | None:
        """Return the line that was typed; "" where nobody did; None after Ctrl-C."""
        if self.expired and _is_terminal():
            self._typed.forget()  # that was for the question before
        self.waiting, self.expired = True, False
        try:
            answer = self._typed.next(prompt.expires_s)
        except KeyboardInterrupt:
            return None
        finally:
            self.waiting = False
        if prompt.kind == REPEAT and not answer:
            self.expired = True
            self._show("Nobody has answered: the session goes on, and the run is not repeated.")
        return answer or ""


class NoOperator:
    """Takes every prompt as done, and says so: the choice of `--yes`. Nobody is asked."""

    waiting = False
    is_present = False

    def __init__(self, show: Callable[[str], None]) -> None:
        self._show = show

    def ask(self, prompt: Prompt) -> bool:
        """See `drivers.interfaces.Operator`."""
        taken = "not measured again" if prompt.kind == REPEAT else "taken as done"
        self._show(f"{prompt.text} (--yes: {taken})")
        return True
