"""Questions at the terminal: typed answers, and nobody there to type any."""

from __future__ import annotations

import os
import sys
import threading
import time
from dataclasses import replace

import pytest

from drivers.interfaces import Prompt
from labrig.experiment.notices.hooks import Hooks, NotifyingOperator
from labrig.experiment.operator import ConsoleOperator, TypedLines
from protocols.execution.events import OperatorAnswered
from protocols.execution.operator import EXPIRES_S, REPEAT, RecordedOperator

OFFER = Prompt(kind=REPEAT, text="2 of 32 readings do not count.", expires_s=0.3)
REAL_OFFER = replace(OFFER, expires_s=EXPIRES_S)
MOVE = Prompt(kind="move", text="Move the load cell to 5 mm.")


class Clock:
    def now(self):
        return 7.0


@pytest.fixture(params=["a terminal"])
def typing(request, monkeypatch):
    """Standard input that is open, and where to write to it."""
    if request.param == "a terminal":
        pty = pytest.importorskip("pty")
        ours, theirs = pty.openpty()
    else:
        theirs, ours = os.pipe()
    with os.fdopen(theirs, encoding="utf-8", closefd=False) as file:
        monkeypatch.setattr(sys, "stdin", file)
        yield ours
    os.write(ours, b"\n")  # for the thread that still reads
    for number in (ours, theirs):
        os.close(number)


@pytest.fixture
def asked(typing):
    """A console's operator as a session has it, what it says, and what is recorded."""
    said, events = [], []
    console = ConsoleOperator(said.append, TypedLines())
    operator = NotifyingOperator(console, Hooks(None, "s.h5", said.append))
    return RecordedOperator(operator, Clock(), events.append), said, events, typing


@pytest.mark.slow
def test_the_offer_to_repeat_lost_readings_does_not_wait_for_ever(asked):
    operator, said, events, typing = asked
    assert operator.ask(OFFER)
    assert said[-1] == "Nobody has answered: the session goes on, and the run is not repeated."
    assert events[-1] == OperatorAnswered(7.0, OFFER, done=True, expired=True)
    # the next question is answered by what comes once it stands
    later = threading.Timer(1.0, os.write, (typing, b"q\n"))
    later.start()
    assert not operator.ask(MOVE)
    later.join()
    assert events[-1] == OperatorAnswered(7.0, MOVE, done=False)


@pytest.mark.parametrize("typing", ["a pipe"], indirect=True)
def test_without_a_terminal_the_offer_is_decided_at_once_and_takes_no_answer_from_a_pipe(asked):
    operator, said, events, typing = asked
    os.write(typing, b"q\n")
    began_s = time.monotonic()
    assert operator.ask(REAL_OFFER)
    assert time.monotonic() - began_s < 5.0
    assert "Nobody is at a terminal to answer" in said[-1]
    assert "the run is not repeated" in said[-1]
    assert events[-1] == OperatorAnswered(7.0, REAL_OFFER, done=True, expired=True)
    assert not operator.ask(MOVE)  # which what was written was meant for
    assert events[-1] == OperatorAnswered(7.0, MOVE, done=False)


def test_an_answer_in_time_is_taken_as_before(asked):
    operator, _, events, typing = asked
    os.write(typing, b"r\n\n")
    assert not operator.ask(OFFER)
    assert operator.ask(MOVE)
    answered = [(event.done, event.expired) for event in events[1::2]]
    assert answered == [(False, False), (True, False)]


@pytest.mark.slow
def test_an_answer_that_comes_too_late_is_no_answer_to_the_next_question(monkeypatch):
    pty = pytest.importorskip("pty")
    ours, theirs = pty.openpty()
    with os.fdopen(theirs, encoding="utf-8") as file:
        monkeypatch.setattr(sys, "stdin", file)
        typed = TypedLines()
        console = ConsoleOperator(lambda _: None, typed)
        assert console.ask(OFFER)
        os.write(ours, b"r\n")
        while typed._blocks.empty():
            pass
        late = Prompt(kind=REPEAT, text="3 of 32 readings do not count.", expires_s=0.3)
        assert console.ask(late)
        assert console.expired
        os.write(ours, b"\n")
    os.close(ours)


def test_the_end_of_input_repeats_nothing_and_says_that_nobody_answered(asked, monkeypatch):
    operator, _, events, _ = asked
    with open(os.devnull, encoding="utf-8") as nothing:
        monkeypatch.setattr(sys, "stdin", nothing)
        assert operator.ask(OFFER)
    assert events[-1].expired
