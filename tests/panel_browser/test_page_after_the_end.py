"""What the page shows once nothing is measured any more: what holds then, not what held last."""

from __future__ import annotations

import datetime as dt

import pytest

from tests.panel_browser import made_up
from tests.panel_browser.conftest import text_of
from tests.panel_browser.test_page_shows import LAMP, until

DASH = "\N{EN DASH}"
NUMERALS = "[...document.querySelectorAll('.numeral-value')].map((n) => n.innerText)"


def stopped(fake, after_s=330.2):
    """STOP in the middle of run 5, as a run publishes it."""
    wall = (dt.datetime.now(dt.UTC) + dt.timedelta(seconds=fake.ahead_s - 200)).isoformat()
    fake.tell(
        {"type": "run_stopped", "time_s": after_s, "run": 4, "completed": False,
         "lost_samples": 0, "frames_grabbed": 9, "frames_dropped": 0, "log": "broken off"},
        {"type": "output", "time_s": after_s, "state": "safe", "why": "0 V read back", "log": "x"},
        {"type": "ended", "time_s": after_s, "outcome": "aborted", "reason": "STOP was pressed",
         "output": "safe", "wall": wall, "log": "aborted"},
        {**made_up.story()[0], "state": "ended", "code": 4, "text": "aborted: STOP was pressed"},
    )  # fmt: skip


@pytest.mark.parametrize(
    "ahead_s", [0.0, pytest.param(-3600.0, marks=pytest.mark.thorough)], ids=["as ours", "behind"]
)
def test_after_stop_no_number_of_the_last_sample_stands_beside_SAFE(fake, visit, ahead_s):
    fake.ahead_s = ahead_s  # of the computer that dates the end
    page = visit(f"{fake.url}#/run")
    page.wait_for_function(f"{NUMERALS}[0] === '\N{MINUS SIGN}2.00'")
    stopped(fake)
    until(page, LAMP, "SAFE")
    page.wait_for_function(f"{NUMERALS}.every((text) => text === '{DASH}')")
    assert "last \N{MINUS SIGN}2.00 V" in text_of(page, ".strip[data-row='drive_V'] .numeral-last")
    said = text_of(page, ".strips-age")
    assert "nothing is measured now" in said.lower()
    assert "run 5, at 12.9 s" in said
    assert ", 3 min ago" in said


@pytest.mark.thorough
def test_between_two_runs_numbers_are_those_of_the_last_reading_and_say_so(fake, visit):
    page = visit(f"{fake.url}#/run")
    page.wait_for_function(f"{NUMERALS}[0] === '\N{MINUS SIGN}2.00'")
    fake.tell({"type": "run_stopped", "time_s": 330, "run": 4, "completed": True, "log": "x"})
    page.wait_for_function(f"{NUMERALS}.every((text) => text === '{DASH}')")
    assert "run 5, at 12.9 s" in text_of(page, ".strips-age")
    start = {"type": "run_started", "time_s": 400, "run": 5, "log": "run 6 begins"}
    fake.tell(start, made_up.signals(5, 0.0, 1.0, fresh=True))
    page.wait_for_function(f"{NUMERALS}[0] === '0.00'")
    page.wait_for_selector(".strips-age", state="hidden")


@pytest.mark.thorough
@pytest.mark.parametrize("how", ["ended", "lost"])
def test_the_schedule_has_no_now_after_the_end(fake, visit, how):
    page = visit(f"{fake.url}#/run")
    until(page, ".timeline-said", "now ")
    if how == "ended":
        stopped(fake)
    else:
        fake.tell({**made_up.story()[0], "state": "lost", "text": "gone"})
    page.wait_for_function("!document.querySelector('.timeline-said').innerText.startsWith('now')")
    said = text_of(page, ".timeline-said")
    assert said.startswith("ended after 5:30" if how == "ended" else "lost after")
    assert "4 of 14 runs complete" in said
    marks = "[...document.querySelectorAll('.now')].map((mark) => mark.getAttribute('d'))"
    assert set(page.evaluate(marks)) <= {"", None}
    assert page.locator(".cell-now").count() == 0
    assert page.locator(".cell-broken").count() == 1


@pytest.mark.thorough
def test_the_log_counts_from_the_start_whose_date_and_zone_are_told_once(fake, visit):
    page = visit(f"{fake.url}#/run", timezone_id="Europe/Zurich")
    until(page, ".log-times", "times since the start, 2026-11-21 13:00 (UTC+1)")
    assert page.inner_text(".log-lines li:first-child time") == "0:00"
    fake.tell({**made_up.plan(), "clock": "virtual"}, {"type": "warning", "time_s": 9, "log": "w"})
    until(page, ".log-times", "by the session\N{RIGHT SINGLE QUOTATION MARK}s own, virtual clock")


@pytest.mark.thorough
def test_the_newest_line_of_the_log_is_in_sight_until_the_reader_scrolls_away(fake, visit):
    page = visit(f"{fake.url}#/run")
    bottom = """() => {
      const list = document.querySelector('.log-lines');
      return list.scrollHeight > list.clientHeight + 40 &&
        list.scrollHeight - list.scrollTop - list.clientHeight < 4;
    }"""
    page.wait_for_selector(".log-lines li")
    page.wait_for_function(bottom)
    page.evaluate("document.querySelector('.log-lines').scrollTop = 0")
    page.wait_for_timeout(100)
    fake.tell({"type": "warning", "time_s": 9, "text": "w", "log": "a new line"})
    until(page, ".log-lines", "a new line")
    page.wait_for_timeout(100)
    assert page.evaluate("document.querySelector('.log-lines').scrollTop") < 5
