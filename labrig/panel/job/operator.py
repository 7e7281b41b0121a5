"""The operator at the page: a prompt is a message, and so is its answer."""

from __future__ import annotations

import threading
from collections.abc import Callable

from drivers.interfaces import Prompt
from labrig.errors import BadInputError
from labrig.panel.live.event_stream import Message
from labrig.panel.live.messages import MessageEncoder, answer_text
from protocols.execution.stop import StopLevel, StopRequest

_POLL_S = 0.1  # for a stop that was asked for elsewhere, by a signal


class PageOperator:
    """An `Operator`. A request to stop is an answer, too."""

    def __init__(
        self,
        encoder: MessageEncoder,
        publish: Callable[[Message], None],
        stop: StopRequest,
        now: Callable[[], float],
    ) -> None:
        self._encoder = encoder
        self._publish = publish
        self._stop = stop
        self._now = now
        self._changed = threading.Condition()
        self._asking: int | None = None  # the prompt that waits for its answer
        self._kind = ""  # of that prompt
        self._answer: bool | None = None
        self.expired = False  # nobody has answered the last question in its time

    def ask(self, prompt: Prompt) -> bool:
        """See `drivers.interfaces.Operator`."""
        with self._changed:
            self._asking, message = self._encoder.asked(self._now(), prompt)
            self._answer, self._kind, self.expired = None, prompt.kind, False
            self._publish(message)
            until_s = None if prompt.expires_s is None else self._now() + prompt.expires_s
            while self._answer is None and self._stop.level is StopLevel.NONE:
                self._changed.wait(_POLL_S)
                if until_s is not None and self._now() > until_s:
                    self._answer = self.expired = True
            self._asking = None
            done = bool(self._answer)
            answered = self._encoder.answered(self._now(), done, prompt.kind, expired=self.expired)
            self._publish(answered)
            return done

    def answer(self, prompt: int, done: bool) -> str:
        """From the page; the question's number guards against an answer to an earlier one."""
        with self._changed:
            if prompt != self._asking or self._answer is not None:
                raise BadInputError("this question is not being asked any more.")
            self._answer = done
            self._changed.notify()
        return answer_text(self._kind, done)
