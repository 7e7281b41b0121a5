"""The page, the server, a run in its process, the simulated boards: all of them real."""

from __future__ import annotations

import json
import time

import pytest

from labrig.session import open_session
from protocols.planning.loop_timing import LoopTiming
from tests.panel_browser.conftest import text_of
from tests.panel_browser.rig_world import (
    ENDED,
    ENERGISED,
    answer_until,
    enter,
    listen_for_a_press,
    pressed_s,
    start,
    while_going,
)


def tab_to(page, name):
    """With the keyboard alone: Tab until the focus is on what has this name."""
    for _ in range(150):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.innerText?.trim() ?? ''").startswith(name):
            return
    raise AssertionError(f"the keyboard does not reach {name}")


def test_a_whole_run_with_the_keyboard_alone(world, visit):
    page = enter(visit, world, "run")
    page.wait_for_selector("main.page-run")
    tab_to(page, "New run")
    page.keyboard.press("Enter")
    page.wait_for_selector("[data-key='pulse_s']")
    for _ in range(60):  # to the choice of the file
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.id === labrig.page.protocol.select.id"):
            break
    page.keyboard.type("one")
    page.wait_for_function(
        "labrig.page.protocol.name === 'one.toml' && labrig.page.planned?.runs.length === 1"
    )
    tab_to(page, "Start the run")
    page.keyboard.press("Enter")
    page.wait_for_function("location.hash === '#/run' && labrig.job.going")
    asked = 0
    end = time.monotonic() + 120
    while not page.evaluate(ENDED):
        assert time.monotonic() < end
        if page.evaluate(
            "document.querySelector('.prompt:not([hidden]) .go:not(:disabled)') !== null"
        ):
            page.keyboard.press("Control+Enter")
            asked += 1
        page.wait_for_timeout(100)
    assert page.evaluate("labrig.job.ended.outcome") == "completed"
    assert asked >= 1  # moisten
    readings = page.evaluate("[...labrig.job.runs.values()].map((run) => run.readings.size)")
    assert readings == [6]
    runs_s = page.evaluate("labrig.job.plan.runs.reduce((sum, run) => sum + run.duration_s, 0)")
    # a page gets what it can show: on a machine with other work at least a few each second
    assert page.evaluate("labrig.page.view.picture.shown") > 3 * runs_s
    acquired_s = LoopTiming().lead_in_s + runs_s + LoopTiming().tail_s
    assert page.evaluate("labrig.job.counts.signals") == pytest.approx(100 * acquired_s, rel=0.1)
    assert page.evaluate("labrig.page.view.strips.points") > 0.9 * 50 * runs_s
    # late on a busy machine, later where its kernels are compiled first
    page.wait_for_function("labrig.job.curve?.points_px.length > 10", timeout=180_000)
    assert "SAFE" in text_of(page, "#output")
    assert page.locator(".timeline-runs .cell-done").count() == 1
    # a late edge on a busy machine makes a reading invalid; its force is a force all the same
    taken = page.evaluate("[...labrig.job.runs.get(0).readings.values()]")
    forces = {r["voltage_V"]: r["force_mN"] for r in taken if r["kind"] != "discarded"}
    assert forces[2] > forces[0] > forces[-2]
    counted = page.evaluate("labrig.job.means(0).reduce((sum, m) => sum + m.count, 0)")
    assert counted == sum(r["valid"] and r["kind"] != "discarded" for r in taken)


# The same press without a browser: tests/labrig/panel/test_panel_runs.py; the button and the key of
# the page: test_page_stop.py; a run that is stopped by the button: test_restarted_panel.py.
@pytest.mark.thorough
@pytest.mark.alone
@pytest.mark.parametrize("way", ["key", "button of a page that only watches"])
def test_stop_in_the_middle_of_a_pulse_takes_the_voltage_away(world, visit, way):
    page = enter(visit, world)
    start(page, world, "long.toml", f"stop-{way[:3]}.h5")
    other = enter(visit, world) if way != "key" else page
    answer_until(page, ENERGISED)
    page.wait_for_timeout(700)  # well inside the train: it is energised without a pause
    listen_for_a_press(other)
    if way == "key":
        other.keyboard.press("Escape")
    else:
        other.hover("#stop")
        other.mouse.down()
    other.wait_for_function(
        "['good', 'bad'].includes(document.getElementById('stop-said').dataset.kind)"
    )
    took_s = world.gone_s(pressed_s(other))
    said = text_of(other, "#stop-said")
    print(f"{way}: 0 V after {1e3 * took_s:.0f} ms; the page says: {said}")
    assert took_s < 0.2
    assert "output SAFE" in said or "output at 0 V" in said
    answer_until(page, ENDED)
    assert page.evaluate("labrig.job.ended.outcome") == "aborted"
    assert page.evaluate("labrig.job.ended.output") == "safe"


@pytest.mark.thorough
@pytest.mark.alone
def test_reload_and_a_second_browser_in_the_middle_of_a_run(world, visit):
    first = enter(visit, world)
    start(first, world, "long.toml", "two.h5")
    answer_until(first, ENERGISED)
    while_going(first, "labrig.job.runs.get(0)?.readings.size >= 4")
    first.reload()
    while_going(first, "labrig.job?.runs.get(0)?.readings.size >= 4")
    second = enter(visit, world, width=1024, height=768)
    while_going(second, "labrig.job?.runs.get(0)?.readings.size >= 6")
    # a reload keeps control, a second browser watches
    first.wait_for_function("labrig.control.mine")
    assert not second.evaluate("labrig.control.mine")
    while_going(second, "labrig.page?.view.picture.shown > 0 && labrig.job.signals.count > 200")
    force = "[...labrig.job.runs.get(0).readings.values()].slice(0, 6).map((r) => r.force_mN)"
    assert first.evaluate(force) == second.evaluate(force)
    assert first.evaluate("labrig.job.signals.newestTime()") > 2.0


@pytest.mark.thorough
@pytest.mark.alone
def test_a_browser_that_stops_reading_holds_nobody_back(world, visit):
    first, second = enter(visit, world), enter(visit, world)
    start(first, world, "long.toml", "slow.h5")
    answer_until(first, ENERGISED)
    second.wait_for_function("labrig.job.runs.get(0)?.readings.size >= 1")
    # its only thread is busy for 4 s: nothing is read, nothing is drawn
    second.evaluate(
        "setTimeout(() => { const end = Date.now() + 4000; while (Date.now() < end); })"
    )
    had = first.evaluate("[labrig.job.runs.get(0).readings.size, labrig.page.view.picture.shown]")
    first.wait_for_timeout(3000)
    now = first.evaluate("[labrig.job.runs.get(0).readings.size, labrig.page.view.picture.shown]")
    assert now[0] - had[0] >= 4
    assert now[1] - had[1] >= 9
    second.wait_for_function(f"labrig.job.runs.get(0).readings.size > {now[0]}")
    assert first.evaluate("labrig.job.job.state") == "going"
    rows = [volts for _, volts in world.record()]
    assert {round(volts) for volts in rows} == {0, 2, -2}


@pytest.mark.thorough
def test_a_reading_marked_on_the_page_stands_in_the_session(world, visit):
    page = enter(visit, world)
    start(page, world, "long.toml", "marked.h5")
    answer_until(page, "labrig.job.runs.get(0)?.readings.size >= 3")
    # the oldest that a busy machine has not spoiled by itself
    label = page.locator("[aria-label^='Mark reading']").last.get_attribute("aria-label")
    number = int(label.split()[2])
    page.click(f"[aria-label='{label}']")
    page.keyboard.type("something touched the rig")
    page.keyboard.press("Enter")
    page.locator("tr.invalid").filter(has_text="something touched the rig").wait_for()
    log = page.locator(".log-lines")
    log.filter(has_text=f"reading {number} of run 1 is marked invalid").wait_for()
    page.keyboard.press("Escape")
    world.server.ask("POST", "/api/stop", {"why": "it is marked"})
    answer_until(page, ENDED)
    with open_session(world.folder / "marked.h5") as session:
        readings = session.runs[0].readings
        marked = readings[readings["index"] == number - 1][0]
    assert not marked["valid"]
    assert "something touched the rig" in marked["why"]


def test_every_page_keeps_to_the_content_security_policy(world, visit):
    page = visit(world.server.address)
    broken = []
    page.on("console", lambda said: broken.append(said.text) if said.type == "error" else None)
    for name in ("run", "new", "queue", "load-cell", "camera", "library", "log"):
        page.goto(world.url(name))
        page.locator(f"main.page-{name}").wait_for()
        page.locator("main h1").wait_for(state="attached")
    page.wait_for_timeout(500)
    assert broken == []
    policy = page.request.get(f"{world.server.origin}/").headers["content-security-policy"]
    assert "script-src 'self';" in policy


@pytest.mark.thorough  # the form without scripts: test_page_stop.py
@pytest.mark.alone
def test_stop_reaches_a_run_from_a_page_whose_scripts_are_switched_off(world, visit):
    page = enter(visit, world)
    start(page, world, "long.toml", "plain.h5")
    answer_until(page, ENERGISED)
    bare = visit(world.server.address, java_script_enabled=False)
    page.wait_for_timeout(500)
    before_s = time.perf_counter()
    bare.click("#stop")
    page.wait_for_function("labrig.job.ended !== null")
    assert world.gone_s(before_s) < 1.0  # a click is found, scrolled to and aimed at first
    assert page.evaluate("labrig.job.ended.outcome") == "aborted"


def test_the_load_cell_is_calibrated_from_the_page(world, visit):
    page = enter(visit, world, "load-cell")
    page.get_by_label("loads").fill("0, 9.81, 49, 9.81, 0")
    page.click("text=Begin")
    answer_until(page, "labrig.job.weighing?.finished === true")
    page.locator(".step[data-step='now']").filter(has_text="Look at the residuals").wait_for()
    drawn = page.evaluate("labrig.page.residuals.series.map((one) => one.points.length)")
    assert sum(drawn) == 5
    weighing = page.evaluate("labrig.job.weighing")
    assert [round(point["load_mN"], 2) for point in weighing["points"]] == [0, 9.81, 49, 9.81, 0]
    assert max(abs(point["off_mN"]) for point in weighing["points"]) < 0.2
    old = (world.folder / "load_cell.toml").read_text()
    page.click("text=Accept and write load_cell.toml")
    page.locator(".good").filter(
        has_text="load_cell.toml is written; the old one is kept as"
    ).wait_for()
    assert (world.folder / "load_cell.toml").read_text() != old
    assert "V/N" in text_of(page, ".facts-big")


@pytest.mark.thorough
def test_the_camera_is_calibrated_by_pointing(world, visit):
    page = enter(visit, world, "camera")
    page.click("text=Start the camera")
    page.wait_for_function("labrig.page.pointing.picture.shown > 2")
    page.get_by_label("a scale bar").check()
    page.get_by_label("its length").fill("10")
    # the clamp's block in the simulated picture is 10 mm high: its corners serve as the bar's ends
    for name, (u, v) in {"ruler_a": (63, 289), "ruler_b": (64, 366), "clamp": (64, 329)}.items():
        point_at(page, name, u, v)
    found = page.evaluate("labrig.page.px")
    assert found["ruler_a"] == pytest.approx([60.1, 292.7], abs=0.6)
    assert found["clamp"] == pytest.approx([60.4, 327.5], abs=0.8)  # as its optics.json has it
    page.locator(".step >> text='Calibrate'").last.click()
    page.locator(".facts-big").filter(has_text="px/mm").wait_for()
    scale = page.evaluate("labrig.page.calibration.px_per_mm")
    assert scale == pytest.approx(7.0, rel=0.02)
    page.click("text=Accept and write optics.json")
    page.locator(".good").filter(
        has_text="optics.json is written; the old one is kept as"
    ).wait_for()
    optics = json.loads((world.folder / "optics.json").read_text())
    assert optics["px_per_mm"] == pytest.approx(scale)
    page.click("text=End the camera")
    answer_until(page, ENDED)


def point_at(page, name, u, v):
    """The clamp with the keyboard, the others with the pointer."""
    button = f"labrig.page.points.{name}.button"
    page.wait_for_function(f"!{button}.disabled")
    page.evaluate(f"{button}.click()")
    if name == "clamp":
        page.keyboard.press("ArrowRight")
        u0, v0 = page.evaluate("labrig.page.pointing.cross")
        for by, forth, back in (
            (u - u0, "ArrowRight", "ArrowLeft"),
            (v - v0, "ArrowDown", "ArrowUp"),
        ):
            tens, ones = divmod(abs(round(by)), 10)
            way = forth if by > 0 else back
            for key in [f"Shift+{way}"] * tens + [way] * ones:
                page.keyboard.press(key)
        page.keyboard.press("Enter")
    else:
        box = page.locator(".pointing").bounding_box()
        width = page.evaluate("labrig.page.pointing.picture.bitmap.width")
        page.locator(".pointing").click(
            position={"x": (u + 0.5) * box["width"] / width, "y": (v + 0.5) * box["width"] / width}
        )
    page.wait_for_function(f"labrig.page.px.{name} !== undefined")
