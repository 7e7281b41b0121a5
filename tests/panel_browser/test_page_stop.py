"""STOP from the page, when everything else is broken: the server is made up."""

from __future__ import annotations

import pytest

from tests.cases import few
from tests.panel_browser.conftest import text_of


def pressed(fake):
    return [path for method, path, _ in fake.asked if method == "POST" and path.endswith("stop")]


def until_said(page, text):
    page.wait_for_function(
        "(text) => document.getElementById('stop-said').innerText.includes(text)", arg=text
    )


def test_esc_presses_both_ways_at_once(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".mean")
    page.keyboard.press("Escape")
    until_said(page, "output SAFE after 0.07 s")
    fake.until_asked("/api/stop", "/stop")
    assert sorted(pressed(fake)) == ["/api/stop", "/stop"]


@pytest.mark.thorough
def test_one_press_of_the_button_is_one_press(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".mean")
    page.click("#stop")
    until_said(page, "output SAFE")
    fake.until_asked("/api/stop", "/stop")
    page.wait_for_timeout(300)  # for a second press, that must not come
    assert sorted(pressed(fake)) == ["/api/stop", "/stop"]


def test_the_button_acts_when_it_goes_down(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".mean")
    page.hover("#stop")
    page.mouse.down()
    until_said(page, "output SAFE")


@pytest.mark.parametrize("key", few(["Enter", "Space"]))
def test_the_button_works_by_the_keyboard(fake, visit, key):
    page = visit(f"{fake.url}#/run")
    page.focus("#stop")
    page.keyboard.press(key)
    until_said(page, "output SAFE")


def test_esc_stops_from_within_a_field(fake, visit):
    page = visit(f"{fake.url}#/new")
    page.locator("details[open] .field input").first.click()  # the sheet's fields are folded away
    page.keyboard.type("12")
    page.keyboard.press("Escape")
    until_said(page, "output SAFE")


def test_stop_works_when_the_panel_hangs(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".mean")
    fake.hangs = True  # all but the STOP process
    page.keyboard.press("Escape")
    until_said(page, "output SAFE after 0.07 s")


def test_stop_works_when_the_panel_hung_before_the_page_came(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".mean")
    page.wait_for_function("sessionStorage.getItem('labrig-stop-url') !== null")
    fake.hangs = True
    page.reload(wait_until="commit")
    page.wait_for_selector("#stop")
    page.keyboard.press("Escape")
    until_said(page, "output SAFE after 0.07 s")


def test_stop_works_when_no_module_loads(fake, visit):
    page = visit("about:blank")
    page.route("**/static/js/main.js", lambda route: route.abort())
    page.goto(fake.url)
    page.wait_for_selector("#stop")
    page.keyboard.press("Escape")
    until_said(page, "STOP")
    page.wait_for_function("document.getElementById('stop-said').dataset.kind === 'good'")
    fake.until_asked("/stop")


def test_stop_works_without_any_script(fake, visit):
    page = visit(fake.url, java_script_enabled=False)
    page.click("#stop")
    fake.until_asked("/api/stop")
    assert pressed(fake) == ["/api/stop"]


def test_stop_says_what_a_hand_can_do_when_it_reaches_nobody(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".mean")
    page.context.set_offline(True)
    page.keyboard.press("Escape")
    until_said(page, "switch the amplifier off by hand")
    assert page.get_attribute("#stop-said", "data-kind") == "bad"


def test_an_output_that_is_not_safe_is_said_so(fake, visit):
    fake.answers["POST", "/stop"] = {"output": "unknown", "took_s": 8.0, "told": "No answer."}
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".mean")
    page.keyboard.press("Escape")
    until_said(page, "output UNKNOWN")
    assert "Switch the amplifier off by hand." in text_of(page, "#stop-said")


@pytest.mark.parametrize(
    "size",
    [
        (320, 568),
        *(
            pytest.param(size, marks=pytest.mark.thorough)
            for size in ((1920, 1080), (1024, 768), (390, 844))
        ),
    ],
)
def test_stop_and_state_are_in_sight_on_every_page(fake, visit, size):
    page = visit(f"{fake.url}#/run", *size)
    page.wait_for_selector(".mean", state="attached")
    places = set()
    for name in ("run", "new", "load-cell", "camera", "library", "log"):
        page.goto(f"{fake.url}#/{name}")
        page.wait_for_selector(f"main.page-{name}")
        page.evaluate("scrollTo(0, document.body.scrollHeight)")
        places.add(tuple(page.locator("#stop").bounding_box().values()))
        for where in ("#output .lamp-word", "#going .going-word"):
            box = page.locator(where).bounding_box()
            assert box["y"] >= 0, where
            assert box["x"] + box["width"] <= size[0], where
    assert len(places) == 1, "STOP has moved"
    x, y, width, height = places.pop()
    assert width >= 120, "a finger must hit it"
    assert height >= 44
    assert x + width <= size[0]
    assert y + height <= size[1]
    assert not page.evaluate("document.documentElement.scrollWidth > innerWidth"), (
        "scrolls sideways"
    )
