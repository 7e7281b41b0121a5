"""The offer to measure a run again, at the page: its words, its answers, and nobody answering."""

from __future__ import annotations

import threading

import pytest

from drivers.interfaces import Prompt
from labrig.panel.job.operator import PageOperator
from labrig.panel.live.messages import MessageEncoder
from protocols.execution.operator import REPEAT
from protocols.execution.stop import StopRequest

OFFER = Prompt(kind=REPEAT, text="2 of 32 readings do not count", expires_s=0.5)


class Asked:
    """A page operator that is asked in a thread, on a clock that is set by hand."""

    def __init__(self) -> None:
        self.now_s = 10.0
        self.messages: list[dict] = []
        self.operator = PageOperator(
            MessageEncoder(), self.messages.append, StopRequest(), lambda: self.now_s
        )
        self.answers: list[bool] = []
        self.thread = threading.Thread(
            target=lambda: self.answers.append(self.operator.ask(OFFER)), daemon=True
        )
        self.thread.start()
        while not self.messages:
            self.thread.join(0.01)

    def answer(self, *, done: bool) -> str:
        text = self.operator.answer(1, done)
        self.thread.join(10)
        return text


@pytest.mark.parametrize(("done", "text"), [(True, "go on"), (False, "measure it again")])
def test_the_answer_is_logged_as_what_it_means(done, text):
    asked = Asked()
    assert asked.answer(done=done) == text
    assert asked.answers == [done]
    assert asked.messages[-1]["log"] == f"answered: {text}"


def test_a_session_that_nobody_attends_goes_on():
    asked = Asked()
    asked.now_s += 1.0
    asked.thread.join(10)
    assert asked.answers == [True]
    assert asked.operator.expired
    assert asked.messages[-1]["log"] == "nobody answered: go on"
