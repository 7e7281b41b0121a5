"""The live fit: fits when a position is done, and waits while a run is on in real time."""

from __future__ import annotations

import os
import signal
import threading
import time
from contextlib import contextmanager

import pytest

from labrig.analysis import measure
from labrig.analysis.running import RunningAnalysis
from labrig.panel.analysis import live_fit
from labrig.panel.analysis.fitted_session import FittedSession
from labrig.panel.analysis.live_fit import LiveFit
from labrig.panel.analysis.live_process import Words
from labrig.panel.live.event_stream import EventStream
from labrig.session import SessionWriter, open_session
from protocols.execution import events as ev
from tests.labrig.analysis.analysed import LOAD_CELL, record_with
from tests.labrig.session.session_recording import TEXTS, session_events, settings, small_schedule

WAIT_S = 60.0


def until(holds):
    end_s = time.monotonic() + WAIT_S
    while not holds():
        assert time.monotonic() < end_s
        threading.Event().wait(0.02)


# ------------------------------------------------------------------------- what the process reads


@pytest.mark.slow
def test_runs_are_measured_one_by_one_as_the_whole_analysis_measures_them(tmp_path):
    path = record_with(tmp_path / "s.h5", small_schedule(), frame_shape=None)
    with open_session(path) as session:
        whole = measure(session).conditions
    running = RunningAnalysis(path)
    counts = []
    while (found := running.measure_next()) is not None:
        counts.append(len(found.conditions))
        last = found
    assert counts == [3, 6, 9]
    assert last.conditions == whole
    assert running.measure_next() is None


@pytest.mark.thorough
@pytest.mark.slow
def test_a_session_is_measured_while_it_is_recorded_and_again_when_a_run_is_marked(tmp_path):
    path, schedule = tmp_path / "s.h5", small_schedule()
    texts = {"texts": TEXTS | {"load_cell.toml": LOAD_CELL}, "frame_shape": None}
    events = list(session_events(schedule))
    first = next(i for i, e in enumerate(events) if isinstance(e, ev.RunStopped)) + 1
    running = RunningAnalysis(path)
    with SessionWriter(path, **(settings(schedule) | texts)) as writer:
        for event in events[:first]:
            writer.handle(event)
        until(lambda: running.measure_next() is not None)
        assert running.measure_next() is None
        mark = ev.ReadingMarked(
            events[first - 1].time_s, run=0, reading=1, why="a hand was in the way", who="Ann"
        )
        writer.handle(mark)
        found = []
        until(lambda: found.append(running.measure_next()) or found[-1] is not None)
        marked = [r for c in found[-1].conditions for r in c.readings if r.index == 1]
        assert [reading.valid for reading in marked] == [False]
        for event in events[first:]:
            writer.handle(event)
    assert running.measure_next() is not None  # also when the file is closed


# ---------------------------------------------------------------------- what the process is told


@contextmanager
def words():
    read, write = os.pipe()
    with os.fdopen(read) as source, os.fdopen(write, "w", buffering=1) as sink:
        yield Words(source), lambda word: sink.write(f"{word}\n")
        sink.write("end\n")


def test_work_waits_between_hold_and_continue():
    with words() as (heard, say):
        heard.wait_while_held()  # nothing holds it at first
        say("hold")
        say("fit")
        assert heard.wait_for_fit()
        waiting = threading.Thread(target=heard.wait_while_held)
        waiting.start()
        waiting.join(0.1)
        assert waiting.is_alive()
        say("continue")
        waiting.join(WAIT_S)
        assert not waiting.is_alive()


def test_the_end_lets_everything_go_on_to_the_last_result():
    with words() as (heard, say):
        say("hold")
        say("end")
        assert not heard.wait_for_fit()
        heard.wait_while_held()


# ------------------------------------------------------------------------ what the panel tells it


class Told:
    """A fitted session that notes what it is told."""

    made: list[Told] = []  # noqa: RUF012 - emptied for each test

    def __init__(self, job, session, hidden, publish):
        self.job, self.session, self.publish = job, session, publish
        self.words = []
        self.made.append(self)

    def __getattr__(self, name):
        return lambda: self.words.append(name)


@pytest.fixture
def followed(tmp_path, monkeypatch):
    monkeypatch.setattr(live_fit, "FittedSession", Told)
    Told.made.clear()
    stream = EventStream()
    followed = LiveFit(tmp_path, tmp_path, stream)
    yield stream, followed
    followed.close()


def job(state="going", kind="run", name="s.h5"):
    return {"type": "job", "id": f"{kind}-{name}", "kind": kind, "state": state, "session": name}


def plan(clock):
    return {"type": "plan", "clock": clock}


@pytest.mark.parametrize(
    ("clock", "words"),
    [
        ("real", ["hold", "run_stopped", "hold", "fit", "run_stopped", "session_ended"]),
        ("virtual", ["run_stopped", "fit", "run_stopped", "session_ended"]),
    ],
)
def test_the_fit_works_between_the_runs_of_a_session_in_real_time(followed, clock, words):
    stream, _ = followed
    begun = [{"type": "run_started", "run": 0}, {"type": "run_stopped", "run": 0}]
    stream.publish_story([job(), plan(clock), *begun])  # before the panel was there
    stream.publish({"type": "run_started", "run": 1})
    stream.publish({"type": "marked", "run": 0})
    stream.publish({"type": "run_stopped", "run": 1})
    stream.publish(job("ended"))
    until(lambda: Told.made and "session_ended" in Told.made[0].words)
    assert Told.made[0].words == words


def test_only_runs_are_fitted_and_each_session_by_a_process_of_its_own(followed):
    stream, _ = followed
    stream.publish_story([job(kind="preflight", name=None)])
    stream.publish_story([job(name="a.h5")])
    until(lambda: len(Told.made) == 1)
    stream.publish_story([job(name="b.h5")])
    until(lambda: len(Told.made) == 2)
    assert [one.session.name for one in Told.made] == ["a.h5", "b.h5"]
    assert Told.made[0].words == ["end"]


def test_a_result_goes_to_the_pages_and_is_kept_for_those_that_ask(followed):
    stream, live = followed
    stream.publish_story([job(name="a.h5")])
    until(lambda: Told.made)
    until(lambda: live._fitted is not None)
    Told.made[0].publish("run-a.h5", {"type": "result", "session": "a.h5", "convergence": {}})
    Told.made[0].publish("run-before", {"type": "result", "session": "old.h5"})
    assert live.result("a.h5")["convergence"] == {}
    assert live.result("old.h5") is None


@pytest.mark.thorough
@pytest.mark.slow
def test_a_process_that_crashes_is_started_again_with_the_next_run(session):
    with open_session(session) as opened:
        places = sum(run.planned.position_m is not None for run in opened.runs)
    results = []
    fitted = FittedSession("job", session, session.parent, lambda _job, r: results.append(r))
    fitted.run_stopped()
    until(lambda: results)
    os.kill(fitted._process.pid, signal.SIGKILL)
    until(lambda: fitted._process is None)
    results.clear()
    fitted.run_stopped()
    fitted.session_ended()
    until(lambda: fitted._process is None)
    assert len(results) == places


@pytest.mark.thorough
def test_a_fit_that_is_held_reads_nothing_until_the_run_is_over(session):
    results = []
    fitted = FittedSession("job", session, session.parent, lambda _job, r: results.append(r))
    fitted.run_stopped()
    until(lambda: results)  # it is loaded, and would be quick
    fitted.hold()
    os.kill(fitted._process.pid, signal.SIGKILL)
    until(lambda: fitted._process is None)
    results.clear()
    fitted.fit()  # a mark; the process that is started for it must know of the run
    threading.Event().wait(4.0)
    assert not results
    fitted.run_stopped()
    until(lambda: results)
    fitted.end()
