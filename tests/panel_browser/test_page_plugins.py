"""Pages of another distribution, in the browser."""

from __future__ import annotations

import pytest

from tests.labrig.panel.plugin_pages import panel_with_plugins
from tests.panel_browser.conftest import text_of


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    with panel_with_plugins(tmp_path_factory.mktemp("site")) as found:
        yield found


def test_the_menu_leads_to_the_pages_of_another_distribution(server, visit):
    page = visit(server.address)
    page.click("#tabs >> text=Plain notes")
    page.locator("main td").filter(has_text="data folder").wait_for()
    assert "All is noted." in text_of(page, "main")
    assert page.locator("main td.num").all_inner_texts() == ["1", "3", "2"]
    sides = [
        head.evaluate("(cell) => getComputedStyle(cell).textAlign")
        for head in page.locator("main thead th").all()
    ]
    assert sides == ["left", "left", "right"]  # a column of numbers alone stands to the right
    page.locator("#tabs a", has_text="Notes").first.click()
    page.locator("main h1").filter(has_text="Notes: from another file, sessions").wait_for()
    assert page.locator("#tabs a[aria-current]").all_inner_texts() == ["Notes"]


@pytest.mark.thorough
def test_the_pages_of_the_docs_work_as_they_stand_there(server, visit):
    page = visit(server.address)
    page.click("#tabs >> text=Humidity")
    page.locator("main h2").filter(has_text="Humidity of the room").wait_for()
    assert page.locator("main td").all_inner_texts() == ["8", "41", "9", "43"]
    page.click("#tabs >> text=As a list")
    page.locator("main li").first.wait_for()
    assert page.locator("main li").all_inner_texts() == ["8: 41", "9: 43"]


@pytest.mark.thorough
def test_a_page_that_has_no_data_says_why(server, visit):
    page = visit(server.address)
    page.click("#tabs >> text=Failing")
    page.locator("main .fault").wait_for()
    said = "the page 'failing' of labrig-notes 0.3 has no data: KeyError: 'ink'."
    assert text_of(page, "main .fault") == said


def test_a_page_that_cannot_show_its_data_says_so(server, visit):
    page = visit(server.address)
    page.route("**/api/pages/plain-notes", lambda route: route.fulfill(json={"tables": {"a": 1}}))
    page.click("#tabs >> text=Plain notes")
    page.locator("main .fault").filter(has_text="tables.map").wait_for()


def test_a_page_whose_module_does_not_load_says_so_and_the_others_work(fake, visit):
    status = fake.status()
    broken = {"name": "broken", "title": "Broken", "menu": True, "script": "/plugins/none.js"}
    fake.status = lambda: {**status, "pages": [*status["pages"], broken]}
    page = visit(f"{fake.url}#/broken")
    page.locator("#net-said").filter(has_text="The page Broken cannot be loaded").wait_for()
    page.click("#tabs >> text=Log")
    page.locator("main h1").filter(has_text="Log of actions").wait_for()
