"""The page of the queue and the button that pauses, with the mouse alone."""

from __future__ import annotations

import pytest

from labrig.config.templates import template_text
from tests.panel_browser.rig_world import enter, leave_alone, rig_world
from tests.panel_browser.test_page_access import violations

DONE_MS = 120_000


@pytest.fixture(scope="module")
def rig(tmp_path_factory):
    """A rig of its own: others may have been calibrated and stopped by the tests before."""
    with rig_world(tmp_path_factory.mktemp("queue") / "rig", lean=True) as found:
        yield found


@pytest.fixture
def world(rig):
    yield rig
    leave_alone(rig)


def states(page):
    return page.evaluate("labrig.job.queue.entries.map(({ session, state }) => [session, state])")


def test_sessions_are_added_ordered_and_run(world, visit):
    page = enter(visit, world, "queue")
    for number, session in enumerate(("first.h5", "second.h5"), start=1):
        page.locator(".queue-add select").first.select_option("one.toml")
        page.locator(".queue-add input").fill(session)
        page.click(".queue-add button:has-text('Add')")
        page.wait_for_function("(n) => labrig.job.queue?.entries.length === n", arg=number)
    page.click("button[aria-label='earlier: second.h5']")
    page.wait_for_function("labrig.job.queue.entries[0].session === 'second.h5'")
    page.click("button:has-text('Start the queue')")
    done = "labrig.job.queue.entries.every(({ state }) => state === 'completed')"
    page.wait_for_function(done, timeout=DONE_MS)
    page.wait_for_function("!labrig.job.queue.going")
    assert states(page) == [["second.h5", "completed"], ["first.h5", "completed"]]
    assert "completed" in page.inner_text(".queue table")


@pytest.mark.thorough
@pytest.mark.parametrize("width", [1440, pytest.param(390, marks=pytest.mark.thorough)])
def test_axe_finds_nothing_on_a_queue_with_sessions(world, visit, width):
    page = enter(visit, world, "queue", width=width)
    page.locator(".queue-add select").first.select_option("short.toml")
    for number in (1, 2):
        page.click(".queue-add button:has-text('Add')")
        page.wait_for_function("(n) => labrig.job.queue?.entries.length === n", arg=number)
    assert violations(page) == []
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.thorough
def test_a_protocol_with_a_fault_is_refused_with_its_sentence(world, visit):
    (world.folder / "hot.toml").write_text(
        (world.folder / "short.toml").read_text().replace("zero_readings = 2", "zero_readings = -2")
    )
    page = enter(visit, world, "queue")
    page.locator(".queue-add select").first.select_option("hot.toml")
    page.click(".queue-add button:has-text('Add')")
    page.wait_for_selector(".queue .fault:has-text('zero_readings')")
    assert states(page) == []


@pytest.mark.thorough
def test_the_run_pauses_after_a_position_and_continues(world, visit):
    # the shipped protocol is long enough to be paused; to run it all would only take long
    (world.folder / "protocol.toml").write_text(template_text("protocol.toml"))
    page = enter(visit, world, "new")
    page.wait_for_selector("button:has-text('Start the run'):enabled")
    page.click("button:has-text('Start the run')")
    page.click("button:has-text('Pause after this position')")
    page.wait_for_selector("#going .going-word:has-text('PAUSED')")
    page.wait_for_selector("#output .lamp-word:has-text('SAFE')")
    begun = page.evaluate("labrig.job.runs.size")
    page.wait_for_timeout(1500)
    assert page.evaluate("labrig.job.runs.size") == begun < 14
    page.click("button:has-text('Continue')")
    page.wait_for_function(f"labrig.job.runs.size > {begun}")
