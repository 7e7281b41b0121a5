"""A panel on a simulated rig, and what that rig's world itself has recorded."""

from __future__ import annotations

import csv
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from labrig.config.templates import write_templates
from tests.labrig.panel.page import TOO_BUSY, TRIES, Page, Server, panel

PROTOCOL = """
moisten = {moisten}
[pulse_train]
zero_readings = 2
readings_per_voltage = {readings}
[[places]]
configuration = "long"
positions_mm = [{positions}]
[extras]
mode = "paper"
"""


class RigWorld:
    """A panel and its folder."""

    def __init__(self, server: Server, folder: Path) -> None:
        self.server = server
        self.folder = folder
        self.netloc = server.netloc

    def url(self, page: str = "run") -> str:
        """Of one of its pages, for a browser that is let in already."""
        return f"{self.server.origin}/#/{page}"

    def record(self) -> list[tuple[float, float]]:
        """(time_s, drive_V) as the world has it; a line that is being written is left out."""
        text = (self.folder / ".labrig" / "world_record.csv").read_text()
        rows = csv.DictReader(text[: text.rfind("\n") + 1].splitlines())
        return [(float(row["time_s"]), float(row["drive_V"])) for row in rows]

    def gone_s(self, since_s: float) -> float:
        """How long after a moment (of `time.perf_counter`) the sheet was at 0 V, and stayed."""
        rows = self.record()
        before = [volts for when, volts in rows if when <= since_s]
        assert before, "nothing was recorded before"
        assert abs(before[-1]) > 1, "the sheet was not energised"
        last = max((when for when, volts in rows if volts != 0), default=since_s)
        zero = [when for when, volts in rows if volts == 0 and when > last]
        assert zero, "it is still energised"
        return max(zero[0] - since_s, 0.0)


@contextmanager
def rig_world(folder: Path, *options: str, lean: bool = False) -> Iterator[RigWorld]:
    """A panel on a new rig: `short.toml` is done in seconds, `long.toml` takes half a minute.

    `one.toml` has one position, `short.toml` two.

    `protocol.toml` has four positions.
    """
    write_templates(folder, simulated=True)
    kinds = {
        "one": ("true", 1, "10"), "short": ("true", 3, "5, 10"), "long": ("false", 20, "10"),
        "protocol": ("true", 2, "0, 10, 20, 30"),
    }  # fmt: skip
    for name, (moisten, readings, positions) in kinds.items():
        text = PROTOCOL.format(moisten=moisten, readings=readings, positions=positions)
        (folder / f"{name}.toml").write_text(text)
    with panel(folder / "rig.toml", *options, lean=lean) as server:
        yield RigWorld(server, folder)


def leave_alone(world: RigWorld) -> None:
    """End what goes on and empty the queue."""
    world.server.ask("POST", "/api/stop", {"why": "the test is over"})
    end_s = time.monotonic() + 30
    while (job := world.server.ask("GET", "/api/status")[1]["job"]) is not None:
        if job["state"] in ("ended", "lost"):
            break
        assert time.monotonic() < end_s
        time.sleep(0.1)  # noqa: TID251 - another process is being watched
    if entries := world.server.ask("GET", "/api/queue")[1]["entries"]:
        page = Page(world.server)
        page.take_control(force=True)
        page.do("/api/queue/hold")
        for entry in entries:
            page.do("/api/queue/remove", id=entry["id"])
        page.close()


def enter(visit: Any, world: RigWorld, page: str = "run", **more: Any) -> Any:
    """A browser of its own, let in by the token."""
    found = visit(world.server.address, bypass_csp=True, **more)  # Playwright waits by eval
    found.wait_for_function("window.labrig?.welcomed")
    found.goto(world.url(page))
    found.wait_for_selector(f"main.page-{page.partition('?')[0]}")
    return found


def start(page: Any, world: RigWorld, protocol: str, session: str) -> None:
    """Take control and start a run by HTTP, as the form does: the form has tests of its own."""
    for _ in range(TRIES):
        job = page.evaluate(
            """async ([protocol, session]) => {
              const net = await import("/static/js/net.js");
              await labrig.control.take(!labrig.control.free);
              const body = { protocol, sheet: "sheet.toml", session, clock: "real" };
              return (await net.post("/api/run", body)).id;
            }""",
            [protocol, session],
        )
        begun = f"(id) => labrig.job.job?.id === id && (labrig.job.started || {ENDED})"
        page.wait_for_function(begun, arg=job, timeout=60_000)
        if TOO_BUSY not in (page.evaluate("labrig.job.job.text") or ""):
            return


def energised_page(world: RigWorld, session: str) -> Page:
    """A page without a browser that has started a run, in the middle of its pulses."""
    page = Page(world.server)
    page.take_control(force=True)
    body = {"protocol": "long.toml", "sheet": "sheet.toml", "session": session, "clock": "real"}
    job = page.do("/api/run", **body)
    page.until(lambda m: m["type"] == "job" and m["id"] == job["id"])  # its story has come
    end_s = time.monotonic() + 90
    while not any(m["state"] == "energised" for m in page.of("output")):
        assert time.monotonic() < end_s, "it was not energised"
        ends = [m["text"] for m in page.of("job") if m["id"] == job["id"] and m["state"] == "ended"]
        assert not ends, ends
        for prompt in page.of("prompt"):
            if all(m["prompt"] != prompt["prompt"] for m in page.of("answered")):
                page.ask("POST", "/api/answer", {"prompt": prompt["prompt"], "done": True})
        time.sleep(0.1)  # noqa: TID251 - another process is being watched
    time.sleep(0.7)  # noqa: TID251 - well inside the train: energised without a pause
    return page


def answer_until(page: Any, condition: str, timeout_s: float = 90.0) -> None:
    """Press Go whenever something is asked, until `condition` (JavaScript) holds."""
    end = time.monotonic() + timeout_s
    press = "document.querySelector('.prompt:not([hidden]) .go:not(:disabled)')?.click()"
    while not page.evaluate(f"() => ({condition}) || void ({press})"):
        assert time.monotonic() < end, f"it did not come about: {condition}"
        page.wait_for_timeout(100)


def listen_for_a_press(page: Any) -> None:
    """Keep the moment at which the browser takes the next key or button in."""
    page.evaluate(
        """() => {
          const keep = (event) => (window.pressed_ms ??= performance.timeOrigin + event.timeStamp);
          for (const kind of ["keydown", "pointerdown"]) addEventListener(kind, keep, true);
        }"""
    )


def pressed_s(page: Any) -> float:
    """That moment by `time.perf_counter`: never too late, too early by the quickest answer."""
    earlier_s = []
    for _ in range(10):
        asked_s = time.perf_counter()
        now_ms = page.evaluate("performance.timeOrigin + performance.now()")
        earlier_s.append(asked_s - 1e-3 * now_ms)
    found: float = max(earlier_s) + 1e-3 * page.evaluate("window.pressed_ms")
    return found


def while_going(page: Any, condition: str) -> None:
    """Wait until `condition` (JavaScript) holds; a run that ends before says why."""
    ended = "labrig.job?.ended?.reason ?? labrig.job?.job?.text"
    page.wait_for_function(f"({condition}) || {ENDED}")
    assert page.evaluate(condition), f"the run has ended before: {page.evaluate(ended)}"


ENERGISED = "labrig.job.output?.state === 'energised'"
ENDED = "['ended', 'lost'].includes(labrig.job.job?.state)"
