"""Can everybody read and use it: axe-core's rules, contrast, focus, keyboard, sizes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cases import few
from tests.panel_browser.every_page import PAGES

AXE = (Path(__file__).parent / "vendor" / "axe.min.js").read_text(encoding="utf-8")
RULES = {"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]}


@pytest.mark.parametrize("name", few(PAGES, "run", "new"))
def test_axe_finds_nothing(turn_to, name):
    page = turn_to(name)
    page.wait_for_selector(PAGES[name])
    page.emulate_media(color_scheme="light")
    assert violations(page) == []
    page.emulate_media(color_scheme="dark")
    assert violations(page, ["color-contrast"]) == []


@pytest.mark.thorough  # the run page has its check above
def test_axe_finds_nothing_in_any_state_nor_on_a_phone(full, visit):
    page = visit(f"{full.url}#/run", width=390, height=844)
    page.wait_for_selector(".mean")
    for state in ("safe", "armed", "unknown"):
        full.tell({"type": "output", "time_s": 1, "state": state, "why": "why", "log": "x"})
        page.wait_for_function(f"document.getElementById('output').dataset.state === '{state}'")
        assert violations(page, None if state == "safe" else ["color-contrast"]) == [], state


@pytest.mark.thorough
def test_axe_itself_finds_what_is_wrong(full, visit):
    page = visit(f"{full.url}#/run")
    page.wait_for_selector(".mean")
    page.locator(".runbar select").evaluate("(it) => it.closest('label').replaceWith(it)")
    assert any(rule == "select-name" for rule, _ in violations(page))


def violations(page, rules=None):
    if not page.evaluate("window.axe !== undefined"):  # half a megabyte is sent once
        page.evaluate(f"({{}}, eval)({json.dumps(AXE)})")
    options = RULES if rules is None else {"runOnly": {"type": "rule", "values": rules}}
    # Without what is in order: to describe each element of it takes longer than to look at it.
    found = page.evaluate(
        "async (options) => (await axe.run(document, options)).violations",
        options | {"resultTypes": ["violations"]},
    )
    return [(v["id"], [n["html"][:160] for n in v["nodes"]]) for v in found]


def test_the_keyboard_reaches_everything_in_the_order_of_the_eye(full, visit):
    page = visit(f"{full.url}#/run")
    page.wait_for_selector(".go")
    page.wait_for_function("!document.querySelector('.go').disabled")
    seen = []
    for _ in range(60):
        page.keyboard.press("Tab")
        here = page.evaluate(FOCUS)
        if here is None:
            break
        seen.append(here)
    names = [one["name"] for one in seen]
    wanted = [
        "Skip to the page",
        "STOP",
        "Run",
        "New run",
        "Take control",
        "Stop after this pulse",
        "Go",
    ]
    places = [next(i for i, name in enumerate(names) if name.startswith(one)) for one in wanted]
    assert places == sorted(places), names
    assert all(one["ring"] for one in seen), [one["name"] for one in seen if not one["ring"]]


FOCUS = """() => {
  const at = document.activeElement;
  if (!at || at === document.body) return null;
  const style = getComputedStyle(at);
  const ring = style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) >= 2;
  return { name: (at.innerText || at.ariaLabel || at.placeholder || at.tagName).trim(), ring };
}"""


@pytest.mark.thorough
def test_the_words_that_matter_can_be_read_at_two_metres(full, visit):
    # 8 arc minutes of capital height at 2 m are 4.7 mm; a pixel of a 24 inch screen is 0.277 mm
    page = visit(f"{full.url}#/run", 1920, 1080)
    page.wait_for_selector(".mean")
    wanted = (
        ".lamp-word",
        ".going-word",
        ".stop-word",
        ".numeral-value",
        ".mean strong",
        ".prompt-text",
    )
    for where in wanted:
        size = page.evaluate(
            f"parseFloat(getComputedStyle(document.querySelector('{where}')).fontSize)"
        )
        assert 0.7 * size * 0.277 > 4.7, where


@pytest.mark.thorough
def test_colours_of_plus_and_minus_differ_for_the_colour_blind_and_shapes_do_too(full, visit):
    page = visit(f"{full.url}#/run")
    page.wait_for_selector(".timeline-wave .mark-plus")
    up, down = (
        page.get_attribute(f".timeline-wave .mark-{sign}", "d") for sign in ("plus", "minus")
    )
    assert shape_of(up) != shape_of(down)


def shape_of(path):
    """Which way a triangle points: the sign of its first step."""
    numbers = path.replace("M", "").replace("Z", "").split("L")
    y = [float(pair.split()[1]) for pair in numbers]
    return y[0] < y[1]


@pytest.mark.thorough
def test_the_theme_can_be_chosen_and_stays(full, visit):
    page = visit(f"{full.url}#/run")
    page.wait_for_selector(".mean")
    light = page.evaluate("getComputedStyle(document.body).backgroundColor")
    page.click("#theme")
    page.click("#theme")
    dark = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert light != dark
    page.reload()
    page.wait_for_selector(".mean")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == dark
    trace = page.evaluate("labrig.page.view.strips.colours(labrig.page.view.strips.lines[0]).trace")
    assert trace == "rgb(233, 237, 241)"


def test_a_reading_is_told_by_more_than_colour(full, visit):
    page = visit(f"{full.url}#/run")
    page.wait_for_selector("tr.invalid")
    assert "INVALID" in page.inner_text("tr.invalid")
