"""A rig whose boards are simulated in another process: the page says so, as the file does."""

from __future__ import annotations

import os

import pytest

from labrig.session import open_session
from tests.end_to_end.real_rig import serving
from tests.labrig.panel.page import Page, panel

pytestmark = [
    pytest.mark.thorough,
    pytest.mark.skipif(os.name != "posix", reason="the simulated stage needs a pseudo-terminal"),
]


def test_the_page_says_that_boards_on_the_real_clock_are_simulated(tmp_path):
    with serving(tmp_path) as rig, panel(rig.folder / "rig" / "rig.toml", lean=True) as server:
        page = Page(server)
        try:
            page.take_control()
            page.do("/api/run", protocol="protocol.toml", session="s.h5", clock="real")
            page.until("started")
            page.do("/api/stop", why="enough")
            page.until(lambda m: m["type"] == "job" and m["state"] == "ended")
        finally:
            page.close()
    assert page.of("plan")[-1]["simulated"] is True
    with open_session(rig.folder / "rig" / "s.h5") as session:
        assert session.simulated
        assert session.clock == "real"
