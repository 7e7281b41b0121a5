"""The queue of a panel: checked, ordered, stopped by anything but a completed session."""

from __future__ import annotations

import json
import os
import re
import signal
import sys
import time
from contextlib import suppress
from urllib.parse import urlsplit

import pytest

from labrig.config.templates import write_templates
from labrig.session import open_session
from tests.labrig.panel.page import Page, Server, jobs_of, panel
from tests.labrig.test_hooks import KEEP, told

pytestmark = pytest.mark.slow
PROTOCOL = """
[pulse_train]
zero_readings = 1
readings_per_voltage = 1
[[places]]
configuration = "long"
positions_mm = [{positions}]
[extras]
mode = "paper"
"""


def made(folder):
    """A rig's folder; `short.toml` has one position, `long.toml` four."""
    write_templates(folder, simulated=True)
    for name, positions in (("short", "10"), ("long", "0, 10, 20, 30")):
        (folder / f"{name}.toml").write_text(PROTOCOL.format(positions=positions))
    return folder


def no_job_stays(folder):
    for pid in jobs_of(folder):
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGTERM)


@pytest.fixture
def alone(tmp_path):
    """A folder for a test with panels of its own."""
    yield made(tmp_path / "rig")
    no_job_stays(tmp_path / "rig")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = made(tmp_path_factory.mktemp("queue") / "rig")
    yield found
    no_job_stays(found)


@pytest.fixture(scope="module")
def server(folder):
    """A panel that goes on from test to test."""
    with panel(folder / "rig.toml", lean=True) as found:
        yield found


@pytest.fixture
def page(server, folder):
    """A page that holds control, and a queue with nothing in it."""
    found = Page(server)
    found.take_control(force=True)
    yield found
    found.do("/api/queue/hold")
    found.ask("POST", "/api/stop", {"why": "the test is over"})
    for entry in held(found)["entries"]:
        found.do("/api/queue/remove", id=entry["id"])
    found.close()


def add(page, protocol, session, **more):
    return page.do("/api/queue/add", protocol=protocol, session=session, **more)


def until_begun(page, session):
    """Until the first run of this session has begun: what the page knows is of it from then on."""
    page.until(lambda m: m["type"] == "job" and m["session"] == session)
    page.until("run_started")


def states(queue):
    return [(entry["session"], entry["state"]) for entry in queue["entries"]]


def held(page):
    """The queue once it does not go on any more and nothing of it runs."""
    end_s = time.monotonic() + 90
    while True:
        _, queue = page.ask("GET", "/api/queue")
        if not queue["going"] and "running" not in dict(states(queue)).values():
            return queue
        assert time.monotonic() < end_s, queue
        time.sleep(0.1)  # noqa: TID251 - another process is watched


def test_sessions_run_one_after_the_other_in_their_order(page, folder):
    add(page, "short.toml", "a.h5")
    last = add(page, "short.toml", "b.h5")["entries"][-1]
    page.do("/api/queue/move", id=last["id"], by=-1)
    page.do("/api/queue/start")
    assert states(held(page)) == [("b.h5", "completed"), ("a.h5", "completed")]
    times = {}
    for name in ("a.h5", "b.h5"):
        with open_session(folder / name) as session:
            assert session.outcome == "completed"
            times[name] = session.started
    assert times["b.h5"] < times["a.h5"]
    assert page.until("queue")["going"] is False


@pytest.mark.skipif(os.name != "posix", reason="Windows reads no TZ")
def test_a_session_is_named_by_its_day_also_where_the_time_zone_makes_no_sense(alone, monkeypatch):
    monkeypatch.setenv("TZ", "UTC+99")
    with panel(alone / "rig.toml", lean=True) as server:
        page = Page(server)
        page.take_control()
        (entry,) = page.do("/api/queue/add", protocol="short.toml")["entries"]
        page.close()
    assert re.fullmatch(r"short-\d{4}-\d\d-\d\d-1\.h5", entry["session"])


def test_the_queue_stops_at_a_session_that_is_stopped(page, folder):
    add(page, "long.toml", "stopped.h5")
    add(page, "short.toml", "never.h5")
    page.do("/api/queue/start")
    until_begun(page, "stopped.h5")
    page.do("/api/stop", why="enough")
    queue = held(page)
    assert states(queue) == [("stopped.h5", "stopped"), ("never.h5", "waiting")]
    assert "nothing more was begun" in queue["text"]
    assert not (folder / "never.h5").exists()


def test_a_protocol_beyond_the_limits_is_refused_when_it_is_added(page, folder):
    text = (folder / "short.toml").read_text()
    (folder / "hot.toml").write_text(
        text.replace("[pulse_train]", "[pulse_train]\nvoltages_V=[9, -9]")
    )
    status, answer = page.ask("POST", "/api/queue/add", {"protocol": "hot.toml", "session": "h.h5"})
    assert status == 400
    assert "limits" in answer["error"]


def test_all_are_checked_again_before_the_first_begins(page, folder):
    (folder / "changed.toml").write_text((folder / "short.toml").read_text())
    add(page, "short.toml", "first.h5")
    add(page, "changed.toml", "second.h5")
    (folder / "changed.toml").write_text("nonsense = 1\n")
    status, answer = page.ask("POST", "/api/queue/start", {})
    assert status == 400
    assert "changed.toml" in answer["error"]
    assert not (folder / "first.h5").exists()


def test_entries_can_be_removed_and_get_names_of_their_own(page):
    first = page.do("/api/queue/add", protocol="short.toml")["entries"][0]
    second = page.do("/api/queue/add", protocol="short.toml")["entries"][1]
    assert first["session"].startswith("short-")
    assert first["session"] != second["session"]
    queue = page.do("/api/queue/remove", id=first["id"])
    assert [entry["id"] for entry in queue["entries"]] == [second["id"]]


def test_without_control_the_queue_cannot_be_changed(page, server):
    other = Page(server)
    try:
        for path in ("add", "start", "hold"):
            body = {"protocol": "short.toml"} if path == "add" else {}
            assert other.ask("POST", f"/api/queue/{path}", body)[0] == 403
    finally:
        other.close()


@pytest.mark.thorough
def test_a_held_queue_ends_its_session_and_begins_no_further_one(page):
    add(page, "long.toml", "this.h5")
    add(page, "short.toml", "next.h5")
    page.do("/api/queue/start")
    until_begun(page, "this.h5")
    page.do("/api/queue/hold")
    assert states(held(page)) == [("this.h5", "completed"), ("next.h5", "waiting")]


@pytest.mark.thorough
def test_a_restarted_panel_goes_on_with_a_run_that_lives_and_then_with_the_next(alone):
    server = Server(alone / "rig.toml", lean=True)
    page = Page(server)
    page.take_control(force=True)
    add(page, "long.toml", "lives.h5")
    add(page, "short.toml", "follows.h5")
    page.do("/api/queue/start")
    until_begun(page, "lives.h5")
    page.do("/api/pause", on=True)  # so that it lives until the panel is back
    page.until(lambda m: m["type"] == "state" and m["state"] == "paused")
    server.end(signal.SIGKILL)
    again = Server(alone / "rig.toml", "--port", str(urlsplit(server.origin).port), lean=True)
    try:
        page = Page(again)
        page.until(lambda m: m["type"] == "state" and m["state"] == "paused")
        page.take_control(force=True)
        page.do("/api/pause", on=False)
        found = states(held(page))
    finally:
        again.end()
    assert found == [("lives.h5", "completed"), ("follows.h5", "completed")]


def test_a_panel_that_comes_back_later_begins_nothing_by_itself(alone):
    hidden = alone / ".labrig"
    hidden.mkdir()
    entry = {"id": "e", "protocol": "short.toml", "sheet": "sheet.toml", "session": "x.h5"}
    more = {"clock": "virtual", "estimate_s": None, "job": None, "text": ""}
    queue = {
        "entries": [{**entry, **more, "state": "waiting"}],
        "going": True,
        "by": "",
        "text": "",
    }
    (hidden / "queue.json").write_text(json.dumps(queue))
    server = Server(alone / "rig.toml", lean=True)
    try:
        found = Page(server).ask("GET", "/api/queue")[1]
        assert found["going"] is False
        assert "started again" in found["text"]
        assert states(found) == [("x.h5", "waiting")]
    finally:
        server.end()


@pytest.mark.thorough
@pytest.mark.skipif(os.name != "posix", reason="the simulated stage needs a pseudo-terminal")
def test_a_session_that_needs_hands_waits_and_the_hook_is_told(alone, tmp_path):
    told_in = tmp_path / "told"
    hook = json.dumps([sys.executable, "-c", KEEP, str(told_in)])
    with (alone / "rig.toml").open("a") as text:
        text.write(f"\n[hooks]\ncommand = {hook}\nwaiting_after_s = 0.2\n")
    (alone / "hands.toml").write_text("moisten = true\n" + (alone / "short.toml").read_text())
    server = Server(alone / "rig.toml", lean=True)
    page = Page(server)
    try:
        page.take_control(force=True)
        add(page, "hands.toml", "hands.h5", clock="real")
        page.do("/api/queue/start")
        prompt = page.until("prompt")
        end_s = time.monotonic() + 30
        while not told_in.exists() or not told(told_in):
            assert time.monotonic() < end_s
            time.sleep(0.1)  # noqa: TID251 - another process is watched
        message = told(told_in)[0]
        assert (message["event"], message["session"]) == ("waiting", "hands.h5")
        assert message["text"] == prompt["text"]
        page.do("/api/answer", prompt=prompt["prompt"], done=False)
        assert states(held(page)) == [("hands.h5", "stopped")]
        while told(told_in)[-1]["event"] != "stopped":
            assert time.monotonic() < end_s + 30
            time.sleep(0.1)  # noqa: TID251 - another process is watched
    finally:
        page.close()
        server.end()


@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL")
@pytest.mark.thorough
@pytest.mark.parametrize("how", ["run", "queue"])
def test_a_run_of_the_page_that_is_killed_is_told_to_the_hooks_once(alone, tmp_path, how):
    told_in = tmp_path / "told"
    hook = json.dumps([sys.executable, "-c", KEEP, str(told_in)])
    with (alone / "rig.toml").open("a") as text:
        text.write(f"\n[hooks]\ncommand = {hook}\n")
    server = Server(alone / "rig.toml", lean=True)
    page = Page(server)
    try:
        page.take_control(force=True)
        if how == "run":
            page.do("/api/run", protocol="long.toml", session="killed.h5", clock="virtual")
        else:
            add(page, "long.toml", "killed.h5")
            page.do("/api/queue/start")
        page.until("reading")
        (pid,) = jobs_of(alone)
        os.kill(pid, signal.SIGKILL)
        page.until(lambda m: m["type"] == "job" and m["state"] == "lost")
        end_s = time.monotonic() + 30
        while not told_in.exists() or not told_in.read_text().endswith("\n"):
            assert time.monotonic() < end_s
            time.sleep(0.1)  # noqa: TID251 - another process is watched
        if how == "queue":
            assert states(held(page)) == [("killed.h5", "stopped")]
    finally:
        page.close()
        server.end()
    (one,) = told(told_in)
    assert (one["event"], one["session"]) == ("stopped", "killed.h5")
    assert one["text"] == "the program that ran it was killed. Run labrig recover on the session"
