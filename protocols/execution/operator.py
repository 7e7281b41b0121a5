"""The operator, with every question and answer told as an event."""

from __future__ import annotations

from collections.abc import Callable

from drivers.interfaces import Clock, Operator, Prompt
from protocols.execution.events import Event, OperatorAnswered, OperatorAsked


class RecordedOperator:
    """An `Operator` that tells of what is asked. A manual stage is given the same one."""

    def __init__(self, operator: Operator, clock: Clock, emit: Callable[[Event], None]) -> None:
        self._operator = operator
        self._clock = clock
        self._emit = emit

    def ask(self, prompt: Prompt) -> bool:
        """See `Operator.ask`."""
        self._emit(OperatorAsked(self._clock.now(), prompt))
        done = self._operator.ask(prompt)
        self._emit(OperatorAnswered(self._clock.now(), prompt, done))
        return done
