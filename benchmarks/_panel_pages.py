"""Who looks at a panel: clients that only receive, bare pages that only draw images, and pages."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.labrig.panel.page import Page
from tests.panel_browser.rig_world import RigWorld, enter

PROTOCOL = """
moisten = false
[pulse_train]
zero_readings = 2
pulse_s = 3.0
readings_per_voltage = 25
[[places]]
configuration = "long"
positions_mm = [10]
[extras]
mode = "paper"
"""
VIEWPORT = {"width": 1440, "height": 900}
_LIMIT = "time_under_voltage_s = 30.0"
_BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
_SETTLE_S = 2.0

# An image counts when it is on the canvas and the browser is about to show it; its age is by the
# server's clock. Trace updates: how often the charts were drawn anew.
_LISTEN = """() => {
  window.ages = [];
  window.updates = 0;
  const { picture, strips } = labrig.page.view;
  picture.onshown = (image) => requestAnimationFrame(() => ages.push(labrig.job.ageOf(image)));
  const show = strips.show.bind(strips);
  strips.show = () => { window.updates += 1; show(); };
}"""
_TAKE = """() => {
  const found = [performance.now(), window.ages, window.updates];
  window.ages = [];
  window.updates = 0;
  return found;
}"""
# The least that a page can do: the socket, the decoder, one canvas of the same size.
_BARE = """async ([width, height]) => {
  const { Socket } = await import("/static/js/socket.js");
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  document.documentElement.append(canvas);
  const context = canvas.getContext("2d", { alpha: false });
  window.ages = [];
  const socket = new Socket("/ws", {
    message() {},
    alive() {},
    async binary(header, buffer, start) {
      if (header.type !== "picture") return;
      const blob = new Blob([new Uint8Array(buffer, start)], { type: header.mime });
      const bitmap = await createImageBitmap(blob);
      requestAnimationFrame(() => {
        context.drawImage(bitmap, 0, 0, width, height);
        bitmap.close();
        socket.seen(header);
        requestAnimationFrame(() => ages.push(socket.clock.now_s() - header.exposed_s));
      });
    },
  });
}"""
_CANVAS = "[labrig.page.view.picture.canvas.width, labrig.page.view.picture.canvas.height]"

Visit = Callable[..., Any]


@dataclass(frozen=True, kw_only=True)
class Seen:
    """What the clients of one measurement saw, and what the processes used."""

    clients: int
    images_hz: list[float]
    updates_hz: list[float]
    latencies_s: list[float]
    cpu: dict[str, float]  # of one core


@contextmanager
def running(world: RigWorld) -> Iterator[None]:
    """Run under voltage, until the block ends: one train of pulses for more than two minutes."""
    rig = world.folder / "rig.toml"
    rig.write_text(rig.read_text().replace(_LIMIT, "time_under_voltage_s = 300.0"))
    (world.folder / "endless.toml").write_text(PROTOCOL)
    page = Page(world.server)
    page.take_control()
    body = {"protocol": "endless.toml", "sheet": "sheet.toml", "session": "b.h5", "clock": "real"}
    page.do("/api/run", **body)
    while not any(m.get("state") == "energised" for m in page.of("output")):
        for prompt in page.of("prompt"):
            if all(m["prompt"] != prompt["prompt"] for m in page.of("answered")):
                page.ask("POST", "/api/answer", {"prompt": prompt["prompt"], "done": True})
        _wait(0.1)
    page.close()
    yield
    world.server.ask("POST", "/api/stop", {})


@contextmanager
def browsers() -> Iterator[Visit]:
    """Yield what opens a page in a window of its own."""
    from playwright.sync_api import sync_playwright

    path = next(filter(None, map(shutil.which, _BROWSERS)), None)
    if path is None:
        raise SystemExit("benchmarks.panel needs Chromium.")
    with ExitStack() as stack:
        play = stack.enter_context(sync_playwright())
        browser = play.chromium.launch(executable_path=path, args=["--no-sandbox"])
        stack.callback(browser.close)

        def visit(url: str, **more: Any) -> Any:
            page = browser.new_context(viewport=VIEWPORT, **more).new_page()
            page.set_default_timeout(120_000)
            page.goto(url)
            return page

        yield visit


def receivers(world: RigWorld, count: int, duration_s: float) -> Seen:
    """Clients that take everything, acknowledge it, and draw nothing."""
    pages = [Page(world.server) for _ in range(count)]
    _wait(_SETTLE_S)
    had = [len(page.pictures) for page in pages]
    with cpu_used() as used:
        began_s = time.perf_counter()
        _wait(duration_s)
        took_s = time.perf_counter() - began_s
    taken = [page.pictures[n:] for page, n in zip(pages, had, strict=True)]
    for page in pages:
        page.close()
    return Seen(
        clients=count,
        images_hz=[len(images) / took_s for images in taken],
        updates_hz=[],
        latencies_s=[i["came_s"] - i["exposed_s"] for images in taken for i in images],
        cpu=used,
    )


def bare_pages(world: RigWorld, visit: Visit, count: int, duration_s: float) -> Seen:
    """Pages that only draw images, on a canvas of the page's own size."""
    whole = enter(visit, world)
    whole.wait_for_function("labrig.page?.view?.picture.shown > 0")
    size = whole.evaluate(_CANVAS)
    whole.context.close()
    pages = []
    for _ in range(count):
        page = visit(world.server.address, bypass_csp=True)
        page.goto(f"{world.server.origin}/api/status")  # a document of the panel, but no page
        page.evaluate(_BARE, size)
        pages.append(page)
    return _watched(pages, duration_s, traces=False)


def full_pages(world: RigWorld, visit: Visit, count: int, duration_s: float) -> Seen:
    """The page of the run."""
    pages = [enter(visit, world) for _ in range(count)]
    for page in pages:
        page.wait_for_function("labrig.page?.view?.picture.shown > 0")
        page.evaluate(_LISTEN)
    return _watched(pages, duration_s, traces=True)


def _watched(pages: list[Any], duration_s: float, *, traces: bool) -> Seen:
    pages[0].wait_for_timeout(1e3 * _SETTLE_S)
    began_ms = [page.evaluate(_TAKE)[0] for page in pages]
    with cpu_used() as used:
        pages[0].wait_for_timeout(1e3 * duration_s)
    images, updates, ages = [], [], []
    for page, then_ms in zip(pages, began_ms, strict=True):
        now_ms, seen, drawn = page.evaluate(_TAKE)
        took_s = (now_ms - then_ms) / 1e3
        images.append(len(seen) / took_s)
        ages += seen
        if traces:
            updates.append(drawn / took_s)
        page.context.close()
    return Seen(
        clients=len(pages), images_hz=images, updates_hz=updates, latencies_s=ages, cpu=used
    )


@contextmanager
def cpu_used() -> Iterator[dict[str, float]]:
    """Share of a core that the panel's processes use inside the block (Linux)."""
    found: dict[str, float] = {}
    kinds = {"curve_start": "curves", "labrig.panel.job": "run", "labrig panel": "server"}
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
