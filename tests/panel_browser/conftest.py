"""A real Chromium, without a screen, and pages in it that must not speak with anybody else."""

from __future__ import annotations

import json
import shutil
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from labrig.config.templates import template_text
from tests.panel_browser import fake_panel
from tests.panel_browser.every_page import every_page, fill
from tests.panel_browser.rig_world import RigWorld, leave_alone, rig_world
from tests.panel_browser.visits import KeptPage, Visit, visits
from tests.side_by_side import is_alone

# The first has no windows and takes half the processor time.
NAMES = (
    "chromium-headless-shell", "chromium", "chromium-browser",
    "google-chrome", "google-chrome-stable", "msedge",
)  # fmt: skip
HERE = "tests/panel_browser/"  # how the names of its tests begin
SCHEMAS = Path(__file__).parents[2] / "docs" / "schemas"


def pytest_ignore_collect(config: pytest.Config) -> bool | None:
    """All of them are slow: see below."""
    return True if "not slow" in config.option.markexpr else None


def pytest_itemcollected(item: pytest.Item) -> None:
    item.add_marker(pytest.mark.system_package("Chromium"))


@pytest.fixture(scope="session")
def chromium():
    """One browser for all tests."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    path = next(filter(None, map(shutil.which, NAMES)), None)
    if path is None:
        pytest.skip(f"no browser: none of {', '.join(NAMES)} is installed")
    with playwright.sync_playwright() as run:
        browser = run.chromium.launch(executable_path=path, args=["--no-sandbox", "--disable-gpu"])
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def kept_pages(request: pytest.FixtureRequest, chromium: Any) -> tuple[KeptPage, KeptPage]:
    """Pages that the tests of a worker use one after the other; the second is for `enter`.

    That one, on a real rig, draws ten times a second unless a test measures what users are
    promised: tests of how often a page draws have a panel without a rig.
    """
    seldom = not any(map(is_alone, request.session.items))
    return KeptPage(chromium), KeptPage(chromium, seldom=seldom, bypass_csp=True)


@pytest.fixture
def visit(chromium: Any, kept_pages: tuple[KeptPage, KeptPage]) -> Iterator[Visit]:
    """Pages of one test."""
    with visits(chromium, kept_pages) as go:
        yield go


@pytest.fixture
def fake() -> Iterator[fake_panel.FakePanel]:
    """A panel without a rig, in the middle of a made-up session."""
    with made_up_session() as panel:
        yield panel


@pytest.fixture
def full(fake: fake_panel.FakePanel) -> fake_panel.FakePanel:
    """A panel that has something to show on every page."""
    fill(fake)
    return fake


@pytest.fixture(scope="module")
def turn_to(chromium) -> Iterator[Callable[..., Any]]:
    """`turn_to(name, width, height)`: a page of a full panel, in one document for each size.

    For tests that only look: as an operator who goes from page to page, they load nothing anew.
    """
    opened: dict[tuple[int, int], Any] = {}
    with made_up_session() as panel, visits(chromium) as visit:
        fill(panel)

        def turn(name: str, width: int = 1440, height: int = 900) -> Any:
            url = f"{panel.url}#/{name}"
            if (width, height) not in opened:
                opened[width, height] = visit(url, width, height)
            page = opened[width, height]
            page.goto(url)
            page.wait_for_selector(f"main.page-{name.partition('?')[0]}")
            page.wait_for_selector(every_page()[name], state="attached")
            return page

        yield turn


@pytest.fixture(scope="session")
def shared_world(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[RigWorld]:
    """A panel and a rig for all tests of a worker; use `world`.

    It is lean (see `Server`) unless a test measures what users are promised.
    """
    lean = not any(map(is_alone, request.session.items))
    with rig_world(tmp_path_factory.mktemp("browser") / "rig", lean=lean) as found:
        yield found


@pytest.fixture
def world(shared_world: RigWorld) -> Iterator[RigWorld]:
    """A panel and a simulated rig that other tests have used and will use.

    No job goes on and nothing is queued; sessions of others may be there.
    """
    yield shared_world
    leave_alone(shared_world)


@contextmanager
def made_up_session() -> Iterator[fake_panel.FakePanel]:
    with fake_panel.FakePanel() as panel:
        panel.greeting = fake_panel.greeting()
        serve_files(panel)
        yield panel


def serve_files(panel: fake_panel.FakePanel) -> None:
    """The shipped templates and schemas, as the real server serves them."""
    names = ("rig", "sheet", "protocol", "load_cell")
    panel.answers["GET", "/api/schemas"] = {
        name: json.loads((SCHEMAS / f"{name}.schema.json").read_text()) for name in names
    }
    kinds = ("protocol", "sheet")
    panel.answers["GET", "/api/files"] = {
        "files": [{"name": f"{kind}.toml", "kind": kind} for kind in kinds]
    }
    for kind in kinds:
        text = template_text(f"{kind}.toml")
        panel.answers["GET", f"/api/files/{kind}.toml"] = {
            "name": f"{kind}.toml", "kind": kind, "text": text,
            "values": tomllib.loads(text), "errors": [],
        }  # fmt: skip
    panel.answers["POST", "/api/files/check"] = {"ok": True, "errors": [], "text": "checked"}
    panel.answers["POST", "/api/plan"] = fake_panel.made_up.plan()
    panel.answers["GET", "/api/log"] = {"actions": []}


def text_of(page: Any, selector: str) -> str:
    """What stands there, in one line."""
    return " ".join(page.inner_text(selector).split())


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """A browser takes seconds."""
    for item in items:
        if item.nodeid.startswith(HERE):
            item.add_marker(pytest.mark.slow)
