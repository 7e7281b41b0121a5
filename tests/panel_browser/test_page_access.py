"""Can everybody read and use it: axe-core's rules, contrast, focus, keyboard, sizes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

AXE = (Path(__file__).parent / "vendor" / "axe.min.js").read_text(encoding="utf-8")
RULES = {"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]}
SESSION = {
    "name": "a.h5", "started": "2026-11-21T12:00:00Z", "sheet": ["long"], "protocol": "pulse_train",
    "outcome": "aborted", "output": "safe", "reason": "STOP", "simulated": True, "runs": 14,
    "runs_complete": 5, "readings": 160, "invalid": 2, "bytes": 12345678, "duration_s": 930.0,
    "analysed": True, "largest_force_mN": 2.43, "scatter_mN": 0.017, "error": None,
    "fit": {"long": {
        "B_Nm2": 1.2755e-6, "B_sigma": 6.8e-9, "E_Pa": 1.5e8, "EIBM_Nm": {"2.0": 36.6e-6},
        "EIBM_sigma": {"2.0": 1.2e-7}, "rmse_force_mN": 0.022, "rmse_curve_mm": 0.032}},
}  # fmt: skip
MEAN = {"force_mN": 1.0, "scatter_mN": 0.1, "readings": 10}
ROW = {"configuration": "long", "position_mm": 5, "voltage_V": 2.0, "a": MEAN, "b": MEAN}
PAGES = {
    "run": ".mean", "new": "[data-key='pulse_s']", "load-cell": ".plot", "camera": ".step",
    "library": ".library-table tbody tr", "session?name=a.h5": ".facts dd", "log": "main table",
    "compare?a=a.h5&b=b.h5": ".compare-forces tbody tr", "replay?session=a.h5": ".transport",
}  # fmt: skip


@pytest.fixture
def full(fake):
    """A panel that has something to show on every page."""
    fake.answers["GET", "/api/library"] = {"sessions": [SESSION], "total": 1, "damaged": 0}
    fake.answers["GET", "/api/library/session"] = {
        **SESSION,
        "log": [{"time_s": 1, "text": "begun"}],
    }
    fake.answers["GET", "/api/library/compare"] = {"a": SESSION, "b": SESSION, "rows": [ROW]}
    action = {"wall": "2026-11-21T12:00:00Z", "who": "Ann", "what": "started a run"}
    fake.answers["GET", "/api/log"] = {"actions": [action]}
    points = [{"load_mN": load, "mV": 3.0, "off_mN": 0.01} for load in (0, 10, 20)]
    fit = {"sensitivity_V_per_N": 51.0, "sensitivity_sigma_V_per_N": 0.1}
    fit |= {"offset_V": 0.0, "offset_sigma_V": 0.001}
    weighing = {"type": "weighing", "points": points, "wanted": [0, 10, 20, 0]}
    prompt = {
        "type": "prompt", "time_s": 1, "prompt": 99, "kind": "moisten", "configuration": "long",
        "text": "Moisten the sheet.", "position_mm": None, "load_mN": None, "log": "asked",
    }  # fmt: skip
    fake.greeting += [{**weighing, "fit": fit, "finished": False}, prompt]
    return fake


@pytest.mark.parametrize("name", PAGES)
def test_axe_finds_nothing(full, visit, name):
    page = visit(f"{full.url}#/{name}")
    page.wait_for_selector(PAGES[name])
    assert violations(page) == []
    page.emulate_media(color_scheme="dark")
    assert violations(page, ["color-contrast"]) == []


def test_axe_finds_nothing_in_any_state_nor_on_a_phone(full, visit):
    page = visit(f"{full.url}#/run", width=390, height=844)
    page.wait_for_selector(".mean")
    for state in ("safe", "armed", "unknown"):
        full.tell({"type": "output", "time_s": 1, "state": state, "why": "why", "log": "x"})
        page.wait_for_function(f"document.getElementById('output').dataset.state === '{state}'")
        assert violations(page, None if state == "safe" else ["color-contrast"]) == [], state


def test_axe_itself_finds_what_is_wrong(full, visit):
    page = visit(f"{full.url}#/run")
    page.wait_for_selector(".mean")
    page.locator(".runbar select").evaluate("(it) => it.closest('label').replaceWith(it)")
    assert any(rule == "select-name" for rule, _ in violations(page))


def violations(page, rules=None):
    page.evaluate(f"window.axe || ({{}}, eval)({json.dumps(AXE)})")
    options = RULES if rules is None else {"runOnly": {"type": "rule", "values": rules}}
    found = page.evaluate("(options) => axe.run(document, options)", options)
    return [(v["id"], [n["html"][:160] for n in v["nodes"]]) for v in found["violations"]]


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
