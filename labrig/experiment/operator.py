"""Who answers when the session asks for something to be done by hand."""

from __future__ import annotations

import sys
from collections.abc import Callable

from drivers.interfaces import Prompt
from labrig.errors import NotReadyError
from protocols.execution.operator import REPEAT


class ConsoleOperator:
    """The person at the terminal: Enter, it is done; q and Enter, stop the session.

    Ctrl-C while a question stands stops the session, too: nothing is energised then.
    """

    def __init__(self, show: Callable[[str], None]) -> None:
        self._show = show
        self.waiting = False  # the signal handler interrupts the question instead of setting a flag

    def ask(self, prompt: Prompt) -> bool:
        """See `drivers.interfaces.Operator`."""
        if prompt.kind == REPEAT:
            self._show(f"{prompt.text} (Enter: go on; r and Enter: again; Ctrl-C: stop)")
        else:
            self._show(f"{prompt.text} Then press Enter (q and Enter: stop the session).")
        self.waiting = True
        try:
            answer = sys.stdin.readline()
        except KeyboardInterrupt:
            return False
        finally:
            self.waiting = False
        if prompt.kind == REPEAT:  # who is not there to answer wants nothing repeated
            return answer.strip().lower() not in {"r", "repeat", "again", "y", "yes"}
        if not answer:
            raise NotReadyError(
                "Nobody is there to answer: standard input has ended. Run labrig in a terminal, or "
                "with --yes when whatever it asks for is done already."
            )
        return answer.strip().lower() not in {"q", "quit", "stop", "n", "no"}


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
