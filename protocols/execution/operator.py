"""The operator, with every question and answer told as an event."""

from __future__ import annotations

from collections.abc import Callable

from drivers.interfaces import Clock, Operator, Prompt
from protocols.execution.events import Event, OperatorAnswered, OperatorAsked, OperatorNotAsked


class RecordedOperator:
    """An `Operator` that tells of what is asked. A manual stage is given the same one.

    `is_present`: whether there is an operator who can answer. One without the attribute is.
    """

    def __init__(self, operator: Operator, clock: Clock, emit: Callable[[Event], None]) -> None:
        self._operator = operator
        self.is_present: bool = getattr(operator, "is_present", True)
        self._clock = clock
        self._emit = emit

    def ask(self, prompt: Prompt) -> bool:
        """See `Operator.ask`."""
        if not self.is_present:
            self._emit(OperatorNotAsked(self._clock.now(), prompt))
            return self._operator.ask(prompt)
        self._emit(OperatorAsked(self._clock.now(), prompt))
        done = self._operator.ask(prompt)
        self._emit(OperatorAnswered(self._clock.now(), prompt, done))
        return done
