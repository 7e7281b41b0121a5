"""Operator and sample of a new run, notes and photographs, with the mouse in a real browser."""

from __future__ import annotations

import os

import pytest

from labrig.session import open_session
from tests.labrig.test_about import FULL
from tests.labrig.test_note_command import photograph
from tests.panel_browser.conftest import text_of
from tests.panel_browser.rig_world import enter
from tests.panel_browser.test_page_access import violations


@pytest.fixture(scope="module", autouse=True)
def about(shared_world):
    """Who and what is stated of the sheets, while these tests run; a run is short."""
    files = [shared_world.folder / name for name in ("about.toml", "protocol.toml")]
    before = [file.read_text() for file in files]
    files[0].write_text(FULL)
    files[1].write_text((shared_world.folder / "one.toml").read_text())
    yield
    for file, text in zip(files, before, strict=True):
        file.write_text(text)


def picture(page, name):
    """Kept where LABRIG_PICTURES names a folder, to be looked at."""
    if os.environ.get("LABRIG_PICTURES"):
        page.screenshot(path=f"{os.environ['LABRIG_PICTURES']}/{name}.png", full_page=True)


def add_photograph(page, path):
    with page.expect_file_chooser() as chooser:
        page.click("text=Add photograph")
    chooser.value.set_files(path)


def test_operator_and_sample_are_edited_for_one_run_and_notes_are_added_by_which_it_is_found(
    world, visit, tmp_path
):
    page = enter(visit, world, "new")
    sample = page.get_by_label("sample", exact=True)
    page.wait_for_function("[...document.querySelectorAll('.new-about input')].some(i => i.value)")
    assert sample.input_value() == "S-17"
    assert page.get_by_label("operator", exact=True).input_value() == "Ada Example"
    sample.fill("S-18")
    page.get_by_label("operator", exact=True).fill("Cy Other")
    page.get_by_label("session file").fill("edited.h5")
    page.locator("select[id^=clock]").select_option("virtual")
    picture(page, "new")
    page.click("text=Start the run")
    page.locator(".notice").filter(has_text="completed").wait_for()
    notes = page.locator(".notes")
    notes.get_by_label("new note").fill("a <b>bubble</b> at the clamp")
    notes.get_by_text("Add note", exact=True).click()
    page.locator(".notes-list li").filter(has_text="a <b>bubble</b> at the clamp").wait_for()
    assert notes.get_by_label("new note").input_value() == ""
    notes.get_by_label("new note").fill("the clamp")
    add_photograph(page, photograph(tmp_path / "clamp.jpg", size=(300, 400)))
    page.locator(".notes-list img[alt='the clamp']").wait_for()
    notes.get_by_text("Photograph now").click()
    page.locator(".notes-list li").nth(2).wait_for()
    page.wait_for_function(
        "[...document.querySelectorAll('.notes-list img')].every(i => i.naturalWidth === 240)"
        " || document.querySelector('.notes-list img:last-of-type').scrollIntoView()"
    )
    picture(page, "run")
    assert violations(page) == []
    (tmp_path / "no.jpg").write_text("no photograph")
    add_photograph(page, tmp_path / "no.jpg")
    page.locator(".notes .fault").filter(has_text="neither a JPEG nor a PNG").wait_for()
    with open_session(world.folder / "edited.h5") as session:
        assert session.about.sample.identity == "S-18"
        assert session.about.operators == ("Cy Other",)
        assert [note.has_photograph for note in session.notes] == [False, True, True]
    assert (world.folder / "about.toml").read_text() == FULL

    page.goto(world.url("session?name=edited.h5"))
    page.wait_for_selector("main.page-session .facts")
    page.locator(".notes-list li").nth(2).wait_for()
    shown = text_of(page, ".session-two")
    assert "S-18" in shown
    assert "Cy Other" in shown
    picture(page, "session")
    assert violations(page) == []
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    picture(page, "session-phone")
    page.goto(world.url("new"))
    page.wait_for_selector("main.page-new")
    page.wait_for_function("[...document.querySelectorAll('.new-about input')].some(i => i.value)")
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    picture(page, "new-phone")
    assert violations(page) == []

    page = enter(visit, world, "library")
    page.fill("input[type='search']", "S-18 bubble")
    page.wait_for_function("document.querySelectorAll('.library-table tbody tr').length === 1")
    assert "edited.h5" in text_of(page, ".library-table")
    page.fill("input[type='search']", "S-99")
    page.wait_for_function("document.querySelectorAll('.library-table tbody a').length === 0")
