"""A session that a crash has left, recovered with the mouse; the original stays."""

from __future__ import annotations

import shutil

import pytest

from labrig.session import open_session
from labrig.session.recording.journal import journal_path
from labrig.session.recording.writer import SessionWriter
from tests.labrig.panel.page import Page, panel
from tests.labrig.session.session_recording import session_events, settings, small_schedule
from tests.panel_browser.conftest import text_of
from tests.panel_browser.rig_world import RigWorld, enter


@pytest.fixture(scope="module")
def world(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recover")
    schedule = small_schedule(3)
    live = folder / "elsewhere.h5"
    with SessionWriter(live, **settings(schedule)) as writer:
        for number, event in enumerate(session_events(schedule)):
            writer.handle(event)
            if number == 60:
                while not writer._queue.empty:
                    pass
                break
        for name in ("crashed.h5", "again.h5"):
            (folder / "data").mkdir(exist_ok=True)
            shutil.copy(live, folder / "data" / name)
            shutil.copy(journal_path(live), journal_path(folder / "data" / name))
    with panel(None, "--data", str(folder / "data")) as server:
        yield RigWorld(server, folder / "data")


@pytest.mark.thorough
def test_who_does_not_hold_control_recovers_nothing(world):
    page = Page(world.server)
    status, _ = page.ask("POST", "/api/library/recover", {"name": "again.h5"})
    assert status == 403
    page.take_control()
    assert page.ask("POST", "/api/library/recover", {"name": "no.h5"})[0] == 404
    assert page.ask("POST", "/api/library/recover", {"name": "../x.h5"})[0] == 400
    page.do("/api/control", do="release")
    page.close()


def test_a_crashed_session_is_recovered_from_the_library(world, visit):
    before = (world.folder / "crashed.h5").read_bytes()
    page = enter(visit, world, "library")
    row = page.locator(".library-table tr").filter(has_text="crashed.h5")
    row.get_by_role("button", name="Recover").click()
    said = page.locator(".recovered")
    said.filter(has_text="wrote crashed-recovered.h5: crashed").wait_for()
    assert "readings" in said.inner_text()
    page.locator(".library-table tr").filter(has_text="crashed-recovered.h5").wait_for()
    assert (world.folder / "crashed.h5").read_bytes() == before
    assert journal_path(world.folder / "crashed.h5").exists()
    with open_session(world.folder / "crashed-recovered.h5") as session:
        assert session.outcome.value == "crashed"
        assert sum(len(run.readings) for run in session.runs) > 0
    row.first.get_by_role("button", name="Recover").click()
    said.filter(has_text="exists already").wait_for()


@pytest.mark.thorough
def test_the_page_of_a_crashed_session_offers_it_too(world, visit):
    page = enter(visit, world, "session?name=again.h5")
    page.get_by_role("button", name="Recover").click()
    page.locator(".recovered").filter(has_text="wrote again-recovered.h5").wait_for()
    page.click("text=Open again-recovered.h5")
    page.locator(".facts dd").filter(has_text="crashed").first.wait_for()
    assert "Recover" not in text_of(page, ".session-do")
