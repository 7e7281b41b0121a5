"""Runs under a panel, on the real clock, against the simulated boards' own sockets."""

from __future__ import annotations

import csv
import os
import signal
import threading
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from labrig.session import open_session
from protocols.execution.operator import EXPIRES_S
from tests.labrig.panel.page import Page, begin, jobs_of, panel, start
from tests.side_by_side import is_alone

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(os.name != "posix", reason="the simulated stage needs pseudo-terminals"),
]


@pytest.fixture
def rig(rig_folder):
    """The folder; a run that a test leaves behind is ended."""
    yield rig_folder
    for pid in jobs_of(rig_folder):
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGTERM)


@pytest.fixture(scope="module")
def server(request, rig_folder):
    """A panel that is lean (see `Server`) unless a test measures what users are promised."""
    lean = not any(map(is_alone, request.session.items))
    with panel(rig_folder / "rig.toml", lean=lean) as found:
        yield found


@pytest.fixture
def page(server, rig):
    """A page that holds control, of a panel that goes on from test to test."""
    found = Page(server)
    found.take_control(force=True)
    yield found
    found.close()


def record(folder):
    """The world's own rows, as numbers; the clock is that of `time.perf_counter`."""
    text = (folder / ".labrig" / "world_record.csv").read_text()
    rows = csv.DictReader(text[: text.rfind("\n") + 1].splitlines())
    return np.array([[float(row["time_s"]), float(row["drive_V"])] for row in rows])


def pulse(folder):
    """Wait until the world says that a pulse has begun."""
    end_s = time.monotonic() + 60
    while abs(record(folder)[-1, 1]) < 1:
        assert time.monotonic() < end_s
        time.sleep(0.02)  # noqa: TID251 - another process is watched
    time.sleep(0.2)  # noqa: TID251 - into the middle of the pulse


def gone_after(folder, pressed_s):
    """Seconds between a press and the last moment with a voltage, by the world's own record."""
    rows = record(folder)
    zero = rows[(rows[:, 0] >= pressed_s) & (rows[:, 1] == 0)]
    assert len(zero), "the voltage has never gone"
    later = rows[rows[:, 0] > zero[0, 0]]
    assert not later[:, 1].any(), "it came back"
    return zero[0, 0] - pressed_s


def ended(page):
    """The job's end; a busy computer may have lost readings, which are not measured again."""
    answered = set()

    def fits(message):
        offered = is_offer(message) and message["prompt"] not in answered
        return offered or (message["type"] == "job" and message["state"] != "going")

    while is_offer(found := page.until(fits)):
        answered.add(found["prompt"])
        page.ask("POST", "/api/answer", {"prompt": found["prompt"], "done": True})
    return found


def is_offer(message):
    return message["type"] == "prompt" and message["kind"] == "repeat"


def test_a_run_goes_on_when_its_panel_is_killed_and_when_the_next_one_gets_ctrl_c(rig):
    with panel(rig / "rig.toml", leave_job=True, lean=True) as first:
        page = Page(first)
        page.take_control()
        start(page, "survivor.h5", "middle.toml")
        page.until("reading")
        first.end(signal.SIGKILL)
    (job,) = jobs_of(rig)
    with panel(rig / "rig.toml", leave_job=True, lean=True) as second:
        page = Page(second)
        assert page.until("run_started")["run"] == 0
        told = len(page.of("reading"))
        page.until(lambda m: m["type"] == "reading" and m["index"] > told)
        seen = [reading["index"] for reading in page.of("reading")]
        assert seen == list(range(len(seen)))
        second.end(signal.SIGINT)
        assert second.process.returncode == 0
    os.kill(job, 0)
    end_s = time.monotonic() + 60 + EXPIRES_S  # nobody answers an offer to measure a run again
    while jobs_of(rig):
        assert time.monotonic() < end_s
        time.sleep(0.1)  # noqa: TID251 - another process is watched
    with open_session(rig / "survivor.h5") as session:
        assert session.outcome.value == "completed"
        assert len(session.runs[0].readings) > len(seen)


@pytest.mark.alone
@pytest.mark.parametrize("way", ["stop process", pytest.param("panel", marks=pytest.mark.thorough)])
def test_stop_in_the_middle_of_a_pulse_takes_the_voltage_away_in_a_fifth_of_a_second(
    rig, server, page, way
):
    watcher = Page(server)  # STOP is everybody's
    name = f"stopped-{way[:4]}.h5"
    start(page, name)
    pulse(rig)
    pressed_s = time.perf_counter()
    if way == "panel":
        assert watcher.ask("POST", "/api/stop", {"why": "test"})[0] == 200
    else:
        url = page.hello["stop_url"].split("/")[2]
        status, answer = server.ask("POST", "/stop", {"why": "test"}, netloc=url)
        assert status == 200
        assert answer["output"] in {"safe", "armed"}
        assert answer["took_s"] < 0.2
    assert ended(page)["code"] == 4
    assert gone_after(rig, pressed_s) < 0.2
    watcher.close()
    with open_session(rig / name) as session:
        assert session.outcome.value == "aborted"
        assert "STOP was pressed" in session.reason
        assert session.output_state.value == "safe"
        told = [event.text for event in session.events if event.kind == "action"]
        assert any("pressed STOP: test" in text for text in told)
        assert told[0] == "Ann (127.0.0.1) started the run"


@pytest.mark.alone
def test_stop_works_while_the_panel_hangs(rig, server, page):
    start(page, "panel-hangs.h5")
    pulse(rig)
    url = page.hello["stop_url"].split("/")[2]
    os.kill(server.process.pid, signal.SIGSTOP)
    try:
        pressed_s = time.perf_counter()
        assert server.ask("POST", "/stop", {}, netloc=url)[0] == 200
        assert gone_after(rig, pressed_s) < 0.2
    finally:
        os.kill(server.process.pid, signal.SIGCONT)
    assert ended(page)["code"] == 4


@pytest.mark.alone
def test_stop_works_while_the_run_itself_hangs(rig, server, page):
    """Then it is the guard that takes the voltage away, or whoever looks after it."""
    start(page, "run-hangs.h5")
    pulse(rig)
    url = page.hello["stop_url"].split("/")[2]
    job = jobs_of(rig)[0]
    boards = Path(f"/proc/{job}/task/{job}/children").read_text().split()
    os.kill(job, signal.SIGSTOP)
    pressed_s = time.perf_counter()
    status, answer = server.ask("POST", "/stop", {}, netloc=url)
    assert status == 200
    assert gone_after(rig, pressed_s) < 1.0
    assert "did not obey" in answer["told"]
    assert page.until(lambda m: m["type"] == "job" and m["state"] == "lost")["code"] is None
    assert page.until(lambda m: m.get("by") == "guard")["state"] == "safe"
    for pid in boards:  # the simulated boards outlive the job that has started them
        with suppress(ProcessLookupError):
            os.kill(int(pid), signal.SIGTERM)


@pytest.mark.thorough
@pytest.mark.alone  # nothing is lost on the way, by the real clock
def test_pages_see_the_same_though_others_read_nothing_and_only_one_acts(rig, server, page):
    ann, bob = page, Page(server)
    idle = [Page(server, reads=False) for _ in range(3)]
    assert bob.ask("POST", "/api/control", {"do": "take", "name": "Bob"})[0] == 403
    status, answer = bob.ask("POST", "/api/run", {"session": "b.h5"})
    assert (status, answer["error"]) == (
        403, "Ann (127.0.0.1) holds control; take it, or watch.",
    )  # fmt: skip
    start(ann, "two.h5", "short.toml")
    late = Page(server)
    reading = ann.until("reading")
    mark = {"run": 0, "reading": reading["index"], "why": "a draught"}
    assert bob.ask("POST", "/api/mark", mark)[0] == 403
    bob.take_control("Bob", force=True)
    bob.do("/api/mark", **mark)
    assert ann.ask("POST", "/api/mark", mark)[0] == 403
    assert bob.ask("POST", "/api/mark", {**mark, "reading": 999})[0] == 409
    for each in (bob, ann, late):  # Bob first, who may answer
        assert each.until("marked")["who"] == "Bob (127.0.0.1)"
        assert ended(each)["code"] == 0
    wanted = ("run_started", "voltage", "reading", "marked", "run_stopped", "ended")
    shown = [[m for m in p.messages if m["type"] in wanted] for p in (ann, bob, late)]
    assert shown[0] == shown[1] == shown[2]
    assert len(ann.of("reading")) == 2 + 2 + 2 * 3
    assert len(ann.pictures) > 10
    assert ann.pictures[-1]["bytes"][:2] == b"\xff\xd8"
    header, payload = ann.strips[-1]
    assert len(payload) == 4 * 7 * header["count"]
    with open_session(rig / "two.h5") as session:
        row = session.runs[0].readings[reading["index"]]
        assert (bool(row["valid"]), str(row["why"])) == (False, "a draught")
        assert str(session.runs[0].marks[0]["who"]) == "Bob (127.0.0.1)"
        told = [event.text for event in session.events if event.kind == "action"]
        assert "Ann (127.0.0.1) answered done" in told
        assert "Bob (127.0.0.1) took control" in told
        assert session.runs[0].counts.lost_samples == 0
        warned = [event.text for event in session.events if event.kind == "warned"]
        assert not [text for text in warned if "the panel" in text]
    for other in (bob, late):
        other.close()
    for other in idle:  # they take nothing, so closing one takes long
        threading.Thread(target=other.close, daemon=True).start()


def test_the_gentle_stop_waits_for_the_reading(rig, server, page):
    start(page, "gentle.h5")
    pulse(rig)
    page.do("/api/stop_after_pulse")
    assert ended(page)["code"] == 4
    readings = page.of("reading")
    assert readings[-1]["voltage_V"] != 0
    with open_session(rig / "gentle.h5") as session:
        assert len(session.runs[0].readings) == len(readings)


def test_declining_a_prompt_stops_the_session(rig, server, page):
    begin(page, "declined.h5", "short.toml")
    prompt = page.until("prompt")
    assert page.ask("POST", "/api/answer", {"prompt": 99, "done": True})[0] == 409
    status, answer = page.ask("POST", "/api/run", {"session": "other.h5"})
    assert (status, "going on already" in answer["error"]) == (409, True)
    page.do("/api/answer", prompt=prompt["prompt"], done=False)
    assert ended(page)["code"] == 4
