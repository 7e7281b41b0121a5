"""A panel that is killed and started again takes its open pages back."""

from __future__ import annotations

import os
import signal
from urllib.parse import urlsplit

import pytest

from tests.labrig.panel.page import Server
from tests.panel_browser.rig_world import (
    ENDED,
    answer_until,
    enter,
    rig_world,
    start,
    while_going,
)

pytestmark = pytest.mark.skipif(os.name != "posix", reason="the simulated stage needs a pty")


@pytest.fixture
def world(tmp_path):
    with rig_world(tmp_path / "rig", lean=True) as found:
        yield found


def restarted(world):
    """Kill the panel, start another one on the same folder and port."""
    world.server.end(signal.SIGKILL)
    port = str(urlsplit(world.server.origin).port)
    world.server = Server(world.folder / "rig.toml", "--port", port, lean=True)
    return world.server


def back(page, server):
    """Wait until the page is this panel's, whether it had to load itself again or not."""
    stop_url = server.ask("GET", "/api/status")[1]["stop_url"]
    page.wait_for_function("(url) => window.labrig?.status?.stop_url === url", arg=stop_url)


def test_the_open_page_follows_the_run_again_and_stops_it(world, visit):
    page = enter(visit, world)
    start(page, world, "long.toml", "survives.h5")
    answer_until(page, "labrig.job.runs.get(0)?.readings.size > 2")
    world.server.end(signal.SIGKILL)
    page.wait_for_function("labrig.job.alive === false")
    server = restarted(world)
    try:
        back(page, server)
        while_going(page, "labrig.job.alive && labrig.job.runs.get(0)?.readings.size > 4")
        page.wait_for_function("labrig.control.mine")
        assert page.inner_text("#going .going-word") != "NOT HEARD"
        page.locator("#stop-form button").click()
        page.wait_for_function(ENDED)
        page.wait_for_selector("#output .lamp-word:has-text('SAFE')")
    finally:
        server.end()


@pytest.mark.thorough
def test_the_open_page_learns_how_a_run_ended_meanwhile(world, visit):
    page = enter(visit, world)
    page.evaluate(
        """async () => {
          const net = await import("/static/js/net.js");
          await labrig.control.take(true);
          const files = { protocol: "one.toml", session: "quick.h5" };
          await net.post("/api/run", { ...files, clock: "virtual" });
        }"""
    )
    world.server.end(signal.SIGKILL)
    page.wait_for_function("labrig.job.alive === false")
    server = restarted(world)
    try:
        back(page, server)
        page.wait_for_function(f"labrig.job.alive && {ENDED}")
        assert "completed" in page.evaluate("labrig.job.job.text")
    finally:
        server.end()


@pytest.mark.thorough
def test_a_new_token_lets_no_earlier_page_in(world, visit):
    page = enter(visit, world)
    world.server.end(signal.SIGKILL)
    port = str(urlsplit(world.server.origin).port)
    server = Server(world.folder / "rig.toml", "--port", port, "--new-token", lean=True)
    try:
        page.wait_for_selector("#net-said:has-text('open the address')")
    finally:
        server.end()
