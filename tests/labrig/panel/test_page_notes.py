"""Notes, photographs, people and sample at the panel's addresses."""

from __future__ import annotations

import sys
import time
from urllib.parse import urlencode

import cv2
import numpy as np
import pytest

from labrig.session import open_session, recover, verify
from labrig.session.notes.waiting import waiting_path
from tests.labrig.panel.page import Page, killed_job, start
from tests.labrig.session.session_recording import record, small_schedule
from tests.labrig.test_about import FULL

pytestmark = pytest.mark.slow  # the panel's process


@pytest.fixture(scope="module")
def closed(rig_folder):
    path = rig_folder / "closed.h5"
    record(path, small_schedule(positions_m=(0.0,)))
    return path


@pytest.fixture
def page(server):
    found = Page(server)
    found.take_control(force=True)
    yield found
    found.close()


def jpeg(rows=60, columns=80):
    image = np.full((rows, columns, 3), 40, dtype=np.uint8)
    image[rows // 3 : rows // 2] = 220
    return cv2.imencode(".jpg", image)[1].tobytes()


def upload(page, content, **more):
    return page.ask("POST", f"/api/notes/photograph?{urlencode(more)}", content)


def listed(page, session):
    status, found = page.ask("GET", f"/api/notes?session={session}")
    assert status == 200, found
    return found["notes"]


def photograph_of(page, session, note, **more):
    asked = urlencode({"session": session, "identifier": note["identifier"], **more})
    return page.ask("GET", f"/api/notes/photograph?{asked}")


def test_a_note_and_a_photograph_of_a_closed_session_are_in_its_file(page, closed):
    answer = page.do("/api/notes", session=closed.name, text="looks dry", who="Bo")
    assert answer["in_file"]
    content = jpeg(rows=900, columns=1200) + bytes(300_000)  # beyond what other requests may send
    status, answer = upload(page, content, session=closed.name, text="the clamp", name="C:\\a.jpg")
    assert status == 200, answer
    first, second = listed(page, closed.name)
    assert (first["text"], first["who"], first["photograph"]) == ("looks dry", "Bo", False)
    assert (second["text"], second["photograph"]) == ("the clamp", True)
    assert second["who"].startswith("Ann")
    assert photograph_of(page, closed.name, second) == (200, content)
    status, small = photograph_of(page, closed.name, second, width=240)
    assert cv2.imdecode(np.frombuffer(small, np.uint8), cv2.IMREAD_COLOR).shape == (180, 240, 3)
    assert all(check.ok for check in verify(closed))
    page.until(lambda m: m["type"] == "notes" and m["session"] == closed.name)


@pytest.mark.parametrize(
    ("content", "status", "why"),
    [
        (b"GIF89a" + bytes(100), 400, "neither a JPEG nor a PNG"),
        (b"", 400, "neither a JPEG nor a PNG"),
        (jpeg()[:20], 400, "neither a JPEG nor a PNG"),
        (bytes((16 << 20) + 1), 413, "more than 16384 kB"),
    ],
)
def test_what_is_no_photograph_is_refused(page, closed, content, status, why):
    before = len(listed(page, closed.name))
    found, answer = upload(page, content, session=closed.name)
    assert (found, why in answer["error"]) == (status, True), answer
    assert len(listed(page, closed.name)) == before


def test_a_note_needs_control_a_session_and_a_text(page, server, closed):
    watcher = Page(server)
    status, answer = watcher.ask("POST", "/api/notes", {"session": closed.name, "text": "x"})
    watcher.close()
    assert (status, "holds control" in answer["error"]) == (403, True)
    assert upload(page, jpeg(), session="../outside.h5")[0] == 400
    assert page.ask("POST", "/api/notes", {"session": "gone.h5", "text": "x"})[0] == 404
    status, answer = page.ask("POST", "/api/notes", {"session": closed.name, "text": " "})
    assert (status, "needs a text" in answer["error"]) == (400, True)
    assert photograph_of(page, closed.name, {"identifier": "none"})[0] == 400
    # a page asks for them at once; a new panel has none, and that is no fault
    assert page.ask("GET", "/api/notes?") == (200, {"session": None, "notes": []})


def test_what_is_edited_for_one_run_is_in_its_session_and_not_in_about_toml(page, rig_folder):
    (rig_folder / "about.toml").write_text(f"# mine\n{FULL}")
    status, found = page.ask("GET", "/api/about")
    assert (status, found["errors"], found["values"]["title"]) == (
        200,
        [],
        "Blocked force of aged sheets",
    )
    values = found["values"]
    values["sample"]["identity"] = "S-18"
    values["people"] = [{"name": "Cy Other", "role": "operator"}]
    wrong = {**values, "licence": "mine"}
    files = {"protocol": "short.toml", "clock": "virtual"}
    status, answer = page.ask("POST", "/api/run", {"session": "wrong.h5", "about": wrong, **files})
    assert (status, "licence = 'mine'" in answer["error"]) == (400, True)
    job = page.do("/api/run", session="edited.h5", about=values, **files)
    ended = page.until(
        lambda m: m["type"] == "job" and m["id"] == job["id"] and m["state"] != "going",
        timeout_s=180.0,
    )
    assert ended["code"] == 0, ended
    with open_session(rig_folder / "edited.h5") as session:
        assert session.about.sample.identity == "S-18"
        assert session.about.operators == ("Cy Other",)
        assert session.about.title == "Blocked force of aged sheets"
        assert session.texts["about.toml"].startswith("# mine\n")  # comments are kept
    assert (rig_folder / "about.toml").read_text() == f"# mine\n{FULL}"
    shown = page.ask("GET", "/api/library/session?name=edited.h5")[1]
    assert shown["sample"] == "S-18"
    assert ["identity", "S-18"] in [row for one in shown["about"] for row in one["rows"]]
    found = page.ask("GET", "/api/library?text=cy+other")[1]["sessions"]
    assert [one["name"] for one in found] == ["edited.h5"]


@pytest.mark.thorough
@pytest.mark.skipif(sys.platform != "linux", reason="needs pseudo-terminals and /proc")
def test_notes_of_a_run_survive_the_kill_of_its_process(page, rig_folder):
    session = "killed.h5"
    job = start(page, session)
    assert not page.do("/api/notes", text="while it runs")["in_file"]
    assert upload(page, jpeg(), text="uploaded")[0] == 200
    until_s = time.monotonic() + 30
    while page.ask("POST", "/api/notes/camera", {"text": "camera"})[0] != 200:
        assert time.monotonic() < until_s
    page.until(lambda m: "noted: while it runs" in m.get("log", ""))
    wanted = ["while it runs", "uploaded", "camera"]
    assert [note["text"] for note in listed(page, session)] == wanted
    with killed_job(rig_folder):
        page.until(lambda m: m["type"] == "job" and m["id"] == job["id"] and m["state"] == "lost")
    assert waiting_path(rig_folder / session).exists()
    recover(rig_folder / session, in_place=True)
    assert [note["text"] for note in listed(page, session)] == wanted
    assert not waiting_path(rig_folder / session).exists()
    assert all(check.ok for check in verify(rig_folder / session))
