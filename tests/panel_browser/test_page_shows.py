"""What an operator reads: states, means, marks, prompts, pictures. The server is made up."""

from __future__ import annotations

import pytest

from tests.cases import few
from tests.panel_browser import fake_panel, made_up
from tests.panel_browser.conftest import text_of

LAMP, GOING = "#output .lamp-word", "#going .going-word"


def until(page, selector, text):
    page.wait_for_function(
        "([where, text]) => document.querySelector(where)?.innerText.includes(text)",
        arg=[selector, text],
    )


@pytest.mark.parametrize("state", few(["safe", "armed", "energised", "unknown"], "safe", "unknown"))
def test_the_output_is_told_by_a_word_a_shape_and_a_colour(fake, visit, state):
    page = visit(f"{fake.url}#/run")
    until(page, LAMP, "ENERGISED")
    fake.tell({"type": "output", "time_s": 1, "state": state, "why": "because", "log": "x"})
    until(page, LAMP, state.upper())
    assert page.get_attribute("#output", "data-state") == state
    assert page.get_attribute("#output svg path", "d")
    assert state.upper() in page.title()


@pytest.mark.thorough
def test_the_shapes_of_all_states_differ(fake, visit):
    page = visit(f"{fake.url}#/run")
    shapes = page.evaluate("import('/static/js/words.js').then((m) => Object.values(m.SHAPES))")
    assert len(set(shapes)) == len(shapes) >= 5


def test_the_output_is_unknown_once_the_panel_is_not_heard(fake, visit):
    page = visit(f"{fake.url}#/run")
    until(page, LAMP, "ENERGISED")
    fake.hangs = True  # the sockets stay open, but nobody says anything
    until(page, LAMP, "UNKNOWN")
    until(page, GOING, "NOT HEARD")
    assert "STOP still works" in text_of(page, "#net-said")
    fake.hangs = False
    until(page, LAMP, "ENERGISED")
    assert "There is no page" not in page.inner_text("#page")


def test_a_lost_run_is_not_shown_as_safe(fake, visit):
    page = visit(f"{fake.url}#/run")
    fake.tell({"type": "output", "time_s": 1, "state": "safe", "why": "0 V", "log": "x"})
    until(page, LAMP, "SAFE")
    job = {**made_up.story()[0], "state": "lost"}
    fake.tell(job)
    until(page, LAMP, "UNKNOWN")
    until(page, ".notice", "Press STOP")


def test_a_run_that_the_guard_has_ended_says_so_and_that_the_output_is_at_0_V(fake, visit):
    page = visit(f"{fake.url}#/run")
    said = "the output guard has ended this run (the program hangs); 0 V written and read back"
    fake.tell({**made_up.story()[0], "state": "lost", "text": said})
    # what reads a session's file waits until it is whole again
    page.locator(".runbar").get_by_role("button", name="Recover").wait_for()
    assert not page.get_by_text("Replay it").is_visible()
    assert not page.get_by_text("Show the result").is_visible()
    until(page, LAMP, "UNKNOWN")
    fake.tell({"type": "output", "time_s": None, "state": "safe", "why": said, "by": "guard"})
    until(page, LAMP, "SAFE")
    until(page, ".notice", said)


@pytest.mark.thorough
def test_why_a_run_has_ended_is_told_once(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".mean")
    why = "the camera has stopped delivering"
    fake.tell(
        {"type": "ended", "time_s": 1, "outcome": "failed", "reason": why, "output": "safe",
         "wall": "2026-11-20T10:00:00Z", "log": "x"}
    )  # fmt: skip
    fake.tell({**made_up.story()[0], "state": "ended", "code": 5, "text": f"failed: {why}"})
    until(page, ".notice", "(code 5)")
    assert text_of(page, ".notice").count(why) == 1


@pytest.mark.thorough
def test_means_and_scatter_leave_out_discarded_and_invalid_readings(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".mean")
    shown = page.evaluate("labrig.job.means(4)")
    taken = [m for m in made_up.story() if m["type"] == "reading" and m["run"] == 4]
    for group in shown:
        used = [
            m["force_mN"]
            for m in taken
            if m["voltage_V"] == group["voltage"] and m["valid"] and m["kind"] != "discarded"
        ]
        assert group["values"] == pytest.approx(used)
        assert group["mean"] == pytest.approx(sum(used) / len(used))
    assert [group["count"] for group in shown] == [10, 5, 3]  # one of 4 at -2 V is invalid
    card = text_of(page, ".mean:first-child")
    assert card.startswith("▲ +2 V")
    assert "5 of 10" in card


@pytest.mark.thorough
def test_each_sampling_point_is_marked_in_the_schedule(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".timeline-wave .mark")
    assert page.locator(".timeline-wave .mark").count() == 32
    assert page.locator(".timeline-wave .mark-planned").count() == 11
    assert page.locator(".timeline-wave .mark-discarded").count() == 2
    assert page.locator(".timeline-wave .mark-invalid").count() == 1
    assert page.locator(".timeline-runs .cell-done").count() == 4
    assert "run 5: long, 20 mm, 12.9 s of 19.2 s" in text_of(page, ".timeline-said")


def test_pictures_curves_and_signals_reach_the_screen(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_function("labrig.page?.view.picture.shown === 1")
    before = page.evaluate("labrig.page.view.strips.points")
    for number in range(301, 311):
        fake.tell(fake_panel.picture_frame(number, -2.0, 314.0 + number / 25))
        fake.tell(
            made_up.signals(4, from_s := 12.9 + 0.04 * (number - 301), from_s + 0.04, fresh=False)
        )
        page.wait_for_function("(n) => labrig.page.view.picture.drawn.frame === n", arg=number)
    assert page.evaluate("labrig.page.view.picture.shown") == 11
    page.wait_for_function("(n) => labrig.page.view.strips.points === n", arg=before + 40)
    assert page.evaluate("labrig.job.signals.newest('drive_V')") == pytest.approx(2.0)
    until(page, ".numeral-value", "+2.00")
    fake.tell(fake_panel.curve(308, -2.0))
    until(page, ".picture-said", "its curve 2 frames behind")
    # the curve's yellow is on the canvas, where the curve is
    u, v = made_up.curve_px(-2.0)[30]
    found = page.evaluate(
        """([u, v]) => {
          const picture = labrig.page.view.picture;
          const [x, y] = picture.toScreen([u, v]);
          return [...picture.context.getImageData(Math.round(x), Math.round(y), 1, 1).data];
        }""",
        [u, v],
    )
    assert found[0] > 200, found
    assert found[1] > 170, found
    assert found[2] < 60, found


@pytest.mark.thorough
def test_a_page_that_falls_behind_is_told_the_story_anew(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".mean")
    fake.tell({"type": "story", "messages": made_up.story(until_run=1)})
    until(page, "#going .going-why", "2 of 14")
    assert page.locator(".timeline-runs .cell-done").count() == 1
    assert page.evaluate("[...labrig.job.runs.keys()]") == [0, 1]


def test_a_prompt_is_shown_and_answered(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".mean")
    fake.tell(prompt(9))
    until(page, ".prompt-text", "Move the load cell to 15 mm, moisten the sheet.")
    until(page, GOING, "WAITING")
    assert page.title().startswith("▶")
    page.keyboard.press("Control+Enter")
    page.wait_for_function("document.querySelector('.go').disabled")
    fake.until_asked("/api/answer")
    fake.tell({"type": "answered", "time_s": 2, "prompt": 9, "done": True, "log": "x"})
    page.wait_for_selector(".prompt", state="hidden")
    paths = [
        (path, body) for _, path, body in fake.asked if path in ("/api/control", "/api/answer")
    ]
    assert [path for path, _ in paths] == ["/api/control", "/api/answer"]
    assert paths[1][1] == {"prompt": 9, "done": True}


def test_who_does_not_hold_control_watches(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".mean")
    fake.tell({"type": "control", "holder": "other", "name": "Ben", "clients": 2}, prompt(9))
    until(page, ".prompt-why", "Ben holds control")
    assert page.is_disabled(".go")
    page.keyboard.press("Control+Enter")
    page.click("text=Take over")
    page.wait_for_function("!document.querySelector('.go').disabled")
    bodies = [body for _, path, body in fake.asked if path.startswith("/api/")]
    assert {"do": "take", "name": "operator", "force": True} in bodies
    assert not any("prompt" in (body or {}) for body in bodies)


@pytest.mark.thorough
def test_enter_in_the_name_takes_control_that_is_free_and_no_other(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".mean")
    fake.tell({"type": "control", "holder": "other", "name": "Ben", "clients": 2})
    page.locator("text=Take over").wait_for()
    name = page.locator("[placeholder='your name']")
    name.fill("Ada")
    name.press("Enter")
    fake.tell({"type": "control", "holder": None, "name": None, "clients": 1})
    page.locator("text=Take control").wait_for()
    assert not any(path == "/api/control" for _, path, _ in fake.asked)
    name.press("Enter")
    page.locator("button", has_text="Release").wait_for()
    taken = [body for _, path, body in fake.asked if path == "/api/control"]
    assert taken == [{"do": "take", "name": "Ada"}]
    assert page.evaluate("document.activeElement.innerText") == "Release"


def prompt(number):
    return {
        "type": "prompt", "time_s": 1, "prompt": number, "kind": "move", "configuration": "long",
        "text": "Move the load cell to 15 mm, moisten the sheet.", "position_mm": 15,
        "load_mN": None, "log": "asked",
    }  # fmt: skip


def test_a_reading_is_marked_invalid_with_a_reason(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.click("[aria-label='Mark reading 19 invalid']")
    page.keyboard.type("bubble under the sheet")
    # readings go on arriving while the reason is typed: the field stays
    fake.tell(made_up.reading(4, made_up.readings()[21], 0.0))
    page.wait_for_function("labrig.job.runs.get(4).readings.size === 22")
    page.keyboard.press("Enter")
    marked = {"run": 4, "reading": 18, "why": "bubble under the sheet"}
    page.wait_for_function("!document.querySelector('.marker-form')")
    assert ("POST", "/api/mark", marked) in fake.asked
    fake.tell({"type": "marked", "time_s": 1, **marked, "who": "Ann", "log": "x"})
    until(page, ".readings-single", "bubble under the sheet (Ann)")
    assert page.evaluate("labrig.job.means(4)[1].count") == 4


@pytest.mark.thorough
def test_how_a_run_ended_is_told_in_full(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".mean")
    reason = "the load cell carries 130 mN, more than 120 % of its capacity."
    fake.tell(
        {"type": "ended", "time_s": 9, "outcome": "failed", "reason": reason, "output": "safe",
         "wall": "", "log": "x"},
        {**made_up.story()[0], "state": "ended", "code": 5, "text": "failed"},
    )  # fmt: skip
    until(page, ".notice", reason)
    until(page, GOING, "FAILED")


@pytest.mark.thorough
def test_readings_that_do_not_count_are_told_in_log_table_and_warning(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".mean")
    until(page, ".lost-readings", "do not count")
    late = made_up.reading(4, made_up.readings()[22], 0.0, valid=False)
    why = "the edge came 9.5 ms late"
    fake.tell({**late, "why": why, "log": f"reading 23 of run 5 (+2 V) does not count: {why}"})
    until(page, ".lost-readings", "run 5 (long, 20 mm): 2 of 30: the edge came 7 to 9.5 ms late")
    line = page.locator(".log-lines .log-reading")
    assert "LOST reading 23 of run 5" in " ".join(line.inner_text().split())
    row = page.locator(".means ~ .readings-two tr.chosen")
    assert "5 of 6" in row.inner_text()
    assert "3 of 4" in row.inner_text()


@pytest.mark.thorough
def test_the_offer_to_measure_a_run_again_has_its_own_answers(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".mean")
    fake.tell({**prompt(9), "kind": "repeat", "text": "2 of 30 readings of run 5 do not count."})
    until(page, ".prompt-text", "do not count")
    until(page, ".go", "Go on")
    page.click("text=Measure it again")
    fake.until_asked("/api/answer")
    assert {"prompt": 9, "done": False} in [body for _, path, body in fake.asked if body]


@pytest.mark.thorough
def test_a_run_that_is_measured_again_is_a_row_of_its_own(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_selector(".mean")
    again = {**made_up.plan()["runs"][4], "run": 14, "repeats": 4}
    fake.tell(
        {**made_up.plan(), "repeats": [again]},
        {"type": "state", "state": "running", "run": 14},
        {"type": "run_started", "time_s": 400, "run": 14, "log": "run 15 begins"},
        {**made_up.reading(4, made_up.readings()[12], 0.0), "run": 14},
    )
    until(page, "#going .going-why", "5 again, of 14")
    until(page, ".readings tr.chosen", "long, 20 mm, run 5 again")
    assert page.evaluate("labrig.job.planned(14).position_mm") == 20


@pytest.mark.thorough
def test_the_strips_and_the_readings_are_those_of_the_sessions_channels(fake, visit):
    page = visit(f"{fake.url}#/run")
    until(page, ".strips", "Current")
    warmth = {
        "key": "oven_temperature_degC", "name": "oven_temperature", "quantity": "temperature",
        "unit": "degC", "column": "oven_temperature_degC", "factor": 1.0,
    }  # fmt: skip
    story = made_up.story()
    for message in story:
        if message["type"] == "plan":
            message["channels"] = [*made_up.CHANNELS[:2], warmth]
        if message["type"] == "reading":
            message["values"]["oven_temperature_degC"] = 21.5
            del message["values"]["current_A"]
    fake.tell({"type": "story", "messages": story})
    until(page, ".strips", "Oven temperature")
    rows = page.locator(".strip").evaluate_all("(all) => all.map((one) => one.dataset.row)")
    assert rows == ["drive_V", "force_mN", "oven_temperature_degC"]
    labels = page.locator(".strip-plot").evaluate_all(
        "(all) => all.map((one) => one.getAttribute('aria-label').split(' over')[0])"
    )
    assert labels == ["Drive in V", "Force in mN", "Oven temperature in degC"]
    until(page, ".readings", "oven temperature, degC")
    text = text_of(page, ".readings")
    assert "21.500" in text
    assert "current" not in text


@pytest.mark.thorough
def test_an_address_without_a_page_says_so(fake, visit):
    page = visit(f"{fake.url}#/moonlight")
    until(page, "#page", 'There is no page "moonlight" here: choose one from the menu.')
    page.click(".tabs a")
    page.wait_for_selector("main.page-run")
    assert "There is no page" not in page.inner_text("#page")
