"""Can everybody read the reports: axe-core's rules, contrast, focus, phones; nothing is cut."""

from __future__ import annotations

from itertools import pairwise

import pytest

from labrig.report.data.kept_diagnosis import keep_diagnosis
from labrig.report.page.diagnosis import write_diagnosis
from labrig.report.page.write import write_report
from tests.labrig.diagnose import made
from tests.labrig.report_data import measure, session
from tests.panel_browser.test_page_access import FOCUS, violations

# The page's own tests (tests/labrig/test_report_page.py) hold its words, its marks and its order.
pytestmark = [pytest.mark.thorough, pytest.mark.slow]
POSITIONS_M = (0.0, 0.015, 0.03)  # more of them are more of the same elements


@pytest.fixture(scope="module")
def pages(tmp_path_factory, data_unchecked):
    """The report of a session with a diagnosis in it, and the diagnosis's own page."""
    folder = tmp_path_factory.mktemp("reports")
    path = session(folder / "made.h5", measure("long", positions_m=POSITIONS_M))
    keep_diagnosis(path, made.found())
    return {
        "report": write_report(path, folder / "report").as_uri(),
        "diagnosis": write_diagnosis(made.indistinguishable(), folder / "diagnosis").as_uri(),
    }


@pytest.mark.parametrize("name", ["report", "diagnosis"])
def test_axe_finds_nothing_in_a_report(pages, visit, name):
    page = visit(pages[name])
    page.evaluate("document.querySelectorAll('details').forEach((it) => { it.open = true; })")
    assert violations(page) == []
    page.emulate_media(color_scheme="dark")
    assert violations(page, ["color-contrast"]) == []


def test_the_page_is_no_wider_than_a_phone(pages, visit):
    page = visit(pages["report"], width=390, height=844)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_axe_finds_nothing_on_a_phone(pages, visit):
    assert violations(visit(pages["report"], width=390, height=844)) == []


def test_no_table_is_cut_at_the_width_of_a_laptop(pages, visit):
    for name in pages:
        page = visit(pages[name])
        page.evaluate("document.querySelectorAll('details').forEach((it) => { it.open = true; })")
        cut = page.evaluate(
            "[...document.querySelectorAll('.scroll, .drawing')]"
            ".filter((it) => it.scrollWidth > it.clientWidth + 1).map((it) => it.ariaLabel)"
        )
        assert cut == []


def test_headings_follow_one_another(pages, visit):
    page = visit(pages["report"])
    levels = page.evaluate(
        "[...document.querySelectorAll('h1,h2,h3,h4')].map((it) => Number(it.tagName[1]))"
    )
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after <= before + 1 for before, after in pairwise(levels))


def test_the_keyboard_reaches_the_report_with_a_ring_around_what_has_the_focus(pages, visit):
    page = visit(pages["report"])
    seen = []
    for _ in range(12):
        page.keyboard.press("Tab")
        seen.append(page.evaluate(FOCUS))
    assert seen[0]["name"] == "Skip to the report"
    assert all(one["ring"] for one in seen)


def test_figures_in_the_page_hold_text_that_can_be_searched(pages, visit):
    page = visit(pages["report"])
    said = page.evaluate(
        "[...document.querySelectorAll('#figure-9 svg text')].map((it) => it.textContent)"
    )
    assert "position p (mm)" in said
