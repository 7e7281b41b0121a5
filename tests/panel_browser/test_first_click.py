"""What a new user does first: `init --simulated`, `panel` there, Start. With the mouse alone."""

from __future__ import annotations

import pytest

from labrig.config.templates import write_templates
from labrig.session import open_session
from tests.labrig.panel.page import panel
from tests.panel_browser.rig_world import ENDED

RUN_MS = 240_000  # 14 positions on a busy computer


@pytest.fixture
def folder(tmp_path, monkeypatch):
    write_templates(tmp_path / "first", simulated=True)
    monkeypatch.chdir(tmp_path / "first")
    return tmp_path / "first"


def press(page, name):
    page.locator(f"a:has-text('{name}'), button:has-text('{name}')").first.click()


def test_all_defaults_end_with_a_complete_session(folder, visit):
    with panel(None) as server:
        page = visit(server.address, bypass_csp=True)
        press(page, "New run")
        page.wait_for_selector("button:has-text('Start the run'):enabled")
        press(page, "Start the run")
        page.wait_for_function("location.hash === '#/run'")
        page.wait_for_function(f"labrig.job.job && {ENDED}", timeout=RUN_MS)
        assert page.inner_text("#going .going-word") == "COMPLETED"
        assert page.inner_text("#output .lamp-word") == "SAFE"
        assert page.evaluate("labrig.job.job.code") == 0
    with open_session(next(folder.glob("*.h5"))) as session:
        assert session.outcome == "completed"
        assert len(session.runs) == 14
