"""The page of results: from the click to the picture, for a session of 42 conditions."""

from __future__ import annotations

import shutil
import statistics
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

from benchmarks.report import Report, Table, busy
from model import Measurements
from tests.labrig.panel.page import Server
from tests.labrig.report_data import measure as measurements_of
from tests.labrig.report_data import session

POSITIONS_M = tuple(0.005 * n for n in range(7))
TURNS = 5
MOST_S = 1.0
_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
# Called in the page when Result is clicked: notes when the browser has painted what matters.
_LISTEN = """() => {
  const link = [...document.querySelectorAll("a")].find((one) => one.textContent === "Result");
  link.addEventListener("click", () => {
    const clicked = performance.now();
    const done = {};
    const charts = () => labrig.page?.charts ?? [];
    const note = (what, is) => {
      if (!(what in done) && is) done[what] = performance.now() - clicked;
    };
    const look = () => {
      const [sheet, force] = charts();
      const drawn = [sheet, force].every((one) => one?.chart.uplot && one.chart.series.length);
      note("picture", drawn);
      note("models", drawn && labrig.page.result?.models.length);
      note("settled", drawn && labrig.page.result?.complete);
      window.took = done;
      if (!("settled" in done)) requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
  });
}"""


def measure() -> Report:
    """Run it."""
    from playwright.sync_api import sync_playwright

    note = busy()
    path = next(filter(None, map(shutil.which, _BROWSERS)))
    fresh, kept = [], []
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as run:
        browser = run.chromium.launch(executable_path=path, args=["--no-sandbox", "--disable-gpu"])
        first = session(Path(folder) / "0.h5", _whole())
        for turn in range(1, TURNS):
            shutil.copy(first, Path(folder) / f"{turn}.h5")
        server = Server(None, "--data", folder)
        try:
            for turn in range(TURNS):
                fresh.append(_took(browser, server, f"{turn}.h5"))
                kept.append(_took(browser, server, f"{turn}.h5"))
        finally:
            server.end()
            browser.close()
    return _report(fresh, kept, note)


def _whole() -> Measurements:
    """Return 42 conditions whose readings have curves of their own."""
    found = measurements_of(positions_m=POSITIONS_M)
    conditions = tuple(
        replace(c, readings=tuple(replace(r, curve=c.curve) for r in c.readings))
        for c in found.conditions
    )
    return replace(found, conditions=conditions)


def _took(browser: Any, server: Server, name: str) -> dict[str, float]:
    context = browser.new_context(viewport={"width": 1440, "height": 900}, bypass_csp=True)
    page = context.new_page()
    page.goto(server.address)
    page.wait_for_function("labrig.welcomed")
    page.evaluate(f"location.hash = '#/session?name={name}'")
    page.locator(".facts dd").first.wait_for()
    page.evaluate(_LISTEN)
    page.get_by_role("link", name="Result", exact=True).click()
    page.wait_for_function("'settled' in (window.took ?? {})", timeout=120_000)
    found: dict[str, float] = page.evaluate("window.took")
    context.close()
    return {what: 1e-3 * value for what, value in found.items()}


def _report(fresh: list[dict[str, float]], kept: list[dict[str, float]], note: str) -> Report:
    rows = {
        "picture of what was measured, not seen before": [one["picture"] for one in fresh],
        "models and bands, computed now": [one["models"] for one in fresh],
        "B and EIBM as positions are added, computed now": [one["settled"] for one in fresh],
        "picture with all of it, computed before": [one["settled"] for one in kept],
    }
    table = Table(
        "From the click to the picture, 42 conditions",
        ("what", "median", "slowest"),
        tuple(
            (what, f"{statistics.median(times):.2f} s", f"{max(times):.2f} s")
            for what, times in rows.items()
        ),
    )
    first, *_, last = rows.values()
    met = max(statistics.median(first), statistics.median(last)) < MOST_S
    return Report(
        (table,),
        dict(rows),
        (f"below {MOST_S:g} s: {'yes' if met else 'no'}", note),
    )
