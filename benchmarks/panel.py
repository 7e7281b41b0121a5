"""The panel: pictures a second, from the camera to the screen, and what pages cost the run.

A run on the simulated boards' own sockets, in real time; pages in headless browsers, which draw
without a graphics card, and clients that only receive. What a page itself costs is the browser's.
"""

from __future__ import annotations

import os
import shutil
import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.report import Report, Table, busy
from tests.labrig.panel.page import Page
from tests.panel_browser.rig_world import ENERGISED, RigWorld, enter, rig_world, start

MEASURED_S = 8.0
CLIENTS = (1, 5)
_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
# Pictures are stamped when they are on the canvas and the browser is about to show it.
_LISTEN = """() => {
  const started = Date.parse(labrig.job.started.wall) / 1000;
  window.shown = [];
  labrig.page.view.picture.onshown = (picture) => requestAnimationFrame(() => {
    const now = (performance.timeOrigin + performance.now()) / 1000;
    window.shown.push(now - started - picture.time_s);
  });
}"""


@dataclass(frozen=True)
class Seen:
    """What the clients of one measurement saw, and what the processes used."""

    what: str
    clients: int
    rates_hz: list[float]
    latencies_s: list[float]
    points_hz: list[float]
    cpu: dict[str, float]  # of one core

    def row(self) -> tuple[str, ...]:
        """For the table."""
        late = self.latencies_s
        return (
            self.what,
            str(self.clients),
            f"{min(self.rates_hz):.1f}",
            f"{min(self.points_hz):.0f}",
            f"{1e3 * statistics.median(late):.0f} ms" if late else "",
            f"{1e3 * statistics.quantiles(late, n=20)[-1]:.0f} ms" if len(late) > 1 else "",
            *(f"{100 * self.cpu.get(name, 0):.0f} %" for name in ("server", "curves", "run")),
        )


def measure() -> Report:
    """Run it."""
    note = busy()
    seen = [_measured(what, count) for what in (_receivers, _browsers) for count in CLIENTS]
    columns = (
        "who looks", "how many", "pictures/s", "moments/s", "to the screen, median", "95 %",
        "server", "curves", "run",
    )  # fmt: skip
    table = Table(
        "25 pictures/s made, three traces of 100 moments/s", columns, tuple(s.row() for s in seen)
    )
    figures = {f"{s.what}_{s.clients}": {
        "pictures_hz": s.rates_hz, "latency_median_s": statistics.median(s.latencies_s or [0]),
        "cpu": s.cpu,
    } for s in seen}  # fmt: skip
    return Report(
        (table,),
        figures,
        (
            "pictures/s and moments/s: of the client that got fewest",
            "server, curves, run: share of one core; curves: what finds the sheet in the pictures",
            "to the screen: from the picture's time stamp until it is drawn; of receivers nothing",
            note,
        ),
    )


def _measured(what: Any, clients: int) -> Seen:
    with tempfile.TemporaryDirectory() as folder, rig_world(Path(folder) / "rig") as world:
        return what(world, clients)  # type: ignore[no-any-return]


def _receivers(world: RigWorld, clients: int) -> Seen:
    """Clients that take everything and draw nothing."""
    pages = [Page(world.server) for _ in range(clients)]
    pages[0].take_control()
    body = {"protocol": "long.toml", "sheet": "sheet.toml", "session": "b.h5", "clock": "real"}
    pages[0].do("/api/run", **body)
    while not any(m.get("state") == "energised" for m in pages[0].of("output")):
        for prompt in pages[0].of("prompt"):
            if all(m["prompt"] != prompt["prompt"] for m in pages[0].of("answered")):
                pages[0].ask("POST", "/api/answer", {"prompt": prompt["prompt"], "done": True})
        _wait(0.1)
    had = [(len(page.pictures), _moments(page)) for page in pages]
    with _cpu() as used:
        began_s = time.perf_counter()
        _wait(MEASURED_S)
        took_s = time.perf_counter() - began_s
    rates = [(len(p.pictures) - n) / took_s for p, (n, _) in zip(pages, had, strict=True)]
    points = [(_moments(p) - n) / took_s for p, (_, n) in zip(pages, had, strict=True)]
    pages[0].do("/api/stop")
    for page in pages:
        page.close()
    return Seen("receiver", clients, rates, [], points, used)


def _moments(page: Page) -> int:
    return sum(header["count"] for header, _ in page.strips)


def _browsers(world: RigWorld, clients: int) -> Seen:
    """Real pages, each in a window of its own."""
    from playwright.sync_api import sync_playwright

    path = next(filter(None, map(shutil.which, _BROWSERS)), None)
    if path is None:
        raise SystemExit("benchmarks.panel needs Chromium.")
    with ExitStack() as stack:
        play = stack.enter_context(sync_playwright())
        browser = play.chromium.launch(executable_path=path, args=["--no-sandbox"])
        stack.callback(browser.close)

        def visit(url: str, **more: Any) -> Any:
            page = browser.new_context(viewport={"width": 1440, "height": 900}, **more).new_page()
            page.set_default_timeout(120_000)
            page.goto(url)
            return page

        pages = [enter(visit, world) for _ in range(clients)]
        start(pages[0], world, "long.toml", "b.h5")
        while not pages[0].evaluate(ENERGISED):
            pages[0].evaluate("document.querySelector('.prompt:not([hidden]) .go')?.click()")
            pages[0].wait_for_timeout(100)
        for page in pages:
            page.evaluate(_LISTEN)
        had = [page.evaluate("[performance.now(), labrig.job.signals.count]") for page in pages]
        with _cpu() as used:
            pages[0].wait_for_timeout(1e3 * MEASURED_S)
        rates, points, late = [], [], []
        for page, (then_ms, count) in zip(pages, had, strict=True):
            now_ms, shown, more = page.evaluate(
                "[performance.now(), shown, labrig.job.signals.count]"
            )
            took_s = (now_ms - then_ms) / 1e3
            rates.append(len(shown) / took_s)
            points.append((more - count) / took_s)
            late += shown
        pages[0].keyboard.press("Escape")
        pages[0].wait_for_function("labrig.job.ended !== null")
    return Seen("browser", clients, rates, late, points, used)


@contextmanager
def _cpu() -> Iterator[dict[str, float]]:
    """Share of a core that the panel's processes use inside the block (Linux)."""
    found: dict[str, float] = {}
    kinds = {"curve_process": "curves", "labrig.panel.job": "run", "labrig panel": "server"}
    before, began_s = _ticks(kinds), time.perf_counter()
    yield found
    took_s = time.perf_counter() - began_s
    for pid, (kind, ticks) in _ticks(kinds).items():
        if pid in before:
            spent_s = (ticks - before[pid][1]) / os.sysconf("SC_CLK_TCK")
            found[kind] = found.get(kind, 0.0) + spent_s / took_s


def _ticks(kinds: dict[str, str]) -> dict[int, tuple[str, int]]:
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            command = (folder / "cmdline").read_text().replace("\0", " ")
            fields = (folder / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        kind = next((name for part, name in kinds.items() if part in command), None)
        if kind and "python" in command:
            found[int(folder.name)] = (kind, int(fields[11]) + int(fields[12]))
    return found


def _wait(duration_s: float) -> None:
    time.sleep(duration_s)  # noqa: TID251 - other processes are being watched
