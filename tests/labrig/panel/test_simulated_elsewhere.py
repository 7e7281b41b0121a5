"""A panel on a rig that is simulated in another process, as a real one is."""

from __future__ import annotations

import os
import shutil

import pytest

from labrig.session import open_session
from tests.end_to_end.real_rig import serving
from tests.labrig.panel.page import Page, panel

pytestmark = [
    pytest.mark.skipif(os.name != "posix", reason="the simulated stage needs a pseudo-terminal"),
]


@pytest.mark.alone
def test_stop_ends_the_voltage_of_a_run_that_the_panel_has_not_started(tmp_path):
    """It said that the output was safe, and read nothing, while the sheet had 2 V."""
    with serving(tmp_path) as rig:
        folder = rig.folder / "panel"
        shutil.copytree(rig.folder / "rig", folder)  # another data folder, the same boards
        with panel(folder / "rig.toml", lean=True) as server:
            page = Page(server)
            stop = page.hello["stop_url"].split("/")[2]
            run = rig.energised()
            status, answer = server.ask("POST", "/stop", {"why": "test"}, netloc=stop)
            assert not rig.is_energised()
            assert status == 200
            assert answer["output"] == "safe"
            assert "no run of this panel is going on; labrig safe:" in answer["told"]
            assert run.wait(30) != 0
            assert not rig.is_energised()
            page.close()


@pytest.mark.thorough
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
