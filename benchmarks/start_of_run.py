"""From the click on Start to a rig that is ready for its first voltage, step by step.

Ready: every device is open and checked, the session's file made, the guard on its post; the run
asks its operator for something, or acquires already. A client stands for the page; it sends the
same request as the button.
"""

from __future__ import annotations

import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from benchmarks.report import Report, Table, busy
from labrig.config.templates import write_templates
from tests.labrig.panel.page import Page, Server

LIMIT_S = 3.0
STARTS = 10
FEWER = 5  # of those that are not measured against the limit
_SETTLED_S = 8.0  # until a process waits for the next order, also on a busy computer
_SHORT = """
moisten = false
[pulse_train]
zero_readings = 1
readings_per_voltage = 1
[[places]]
configuration = "long"
positions_mm = [10]
[extras]
mode = "paper"
"""
Step = tuple[str, float]  # what is done from this time on, in s since the click


class Start:
    """One start: when the page heard of each step, and of the rig being ready."""

    def __init__(self, page: Page, session: str, clock: str) -> None:
        before, clicked_s = _cpu(), time.perf_counter()
        body = {"protocol": "short.toml", "session": session, "clock": clock}
        job = page.do("/api/run", **body)
        page.until(lambda m: m["type"] == "job" and m["id"] == job["id"])
        page.until(_is_ready)
        self.ready_s = time.perf_counter() - clicked_s
        self.cpu_s = _spent(before, _cpu(), _pid_of_job(page))
        steps = [(m["text"], m["since_s"]) for m in page.of("step")]
        self.steps = _durations(steps, self.ready_s)
        page.do("/api/stop")
        page.ended(job)


def _pid_of_job(page: Page) -> int:
    data = Path(page.hello["status"]["data"])
    return int(json.loads((data / ".labrig" / "job.json").read_text())["pid"])


def _cpu() -> dict[int, tuple[int, float]]:
    """Parent and CPU time in s of each process (Linux)."""
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            fields = (folder / "stat").read_text().rpartition(")")[2].split()
            ticks = int(fields[11]) + int(fields[12])
            found[int(folder.name)] = int(fields[1]), ticks / os.sysconf("SC_CLK_TCK")
    return found


def _spent(
    before: dict[int, tuple[int, float]], after: dict[int, tuple[int, float]], leader: int
) -> float:
    """CPU time of a process and its descendants in s; NaN where nobody counts."""
    family = {leader} & after.keys()
    while more := {pid for pid, (parent, _) in after.items() if parent in family} - family:
        family |= more
    used = [after[pid][1] - before.get(pid, (0, 0.0))[1] for pid in family]
    return sum(used) if used else math.nan


def _is_ready(message: dict[str, Any]) -> bool:
    if message["type"] == "job" and message["state"] == "ended":
        raise RuntimeError(message["text"])
    return message["type"] in {"prompt", "run_started"}


def _durations(steps: list[Step], ready_s: float) -> dict[str, float]:
    """How long each step took; the first one is the click's way into the job's process."""
    job_s = steps[-1][1]  # the process counts from its own beginning
    ends = [since for _, since in steps[1:]]
    found = {text: end - since for (text, since), end in zip(steps, ends, strict=False)}
    return {"click, way to the job's process, session file, first run": ready_s - job_s, **found}


@contextmanager
def _panel() -> Iterator[tuple[Page, Path]]:
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "rig"
        write_templates(folder, simulated=True)
        (folder / "short.toml").write_text(_SHORT)
        server = Server(folder / "rig.toml")
        page = Page(server)
        page.take_control(force=True)
        try:
            yield page, folder
        finally:
            page.close()
            server.end()


def _starts(page: Page, name: str, clock: str, wait_s: float, count: int) -> list[Start]:
    found = []
    for number in range(count):
        time.sleep(wait_s)  # noqa: TID251 - another process gets ready
        found.append(Start(page, f"{name}-{number}.h5", clock))
    return found


def _by_command(folder: Path) -> list[float]:
    """`labrig run` from its process' start until its first line about the run."""
    found = []
    for number in range(FEWER):
        files = [str(folder / one) for one in ("rig.toml", "short.toml", "sheet.toml")]
        command = [sys.executable, "-m", "labrig", "run", *files, "-o"]
        began_s = time.perf_counter()
        process = subprocess.Popen(
            [*command, str(folder / f"command-{number}.h5")],
            stderr=subprocess.PIPE,
            text=True,
        )
        for line in process.stderr or ():
            if line.startswith("session: 0 %"):
                break
        found.append(time.perf_counter() - began_s)
        process.communicate()
    return found


def measure() -> Report:
    """Measure all ways to start."""
    note = busy()
    seen: dict[str, list[float]] = {}
    cpu: dict[str, list[float]] = {}
    with _panel() as (page, folder):
        ready = _starts(page, "ready", "virtual", _SETTLED_S, STARTS)
        seen["page, simulated rig"] = [start.ready_s for start in ready]
        cpu["page, simulated rig"] = [start.cpu_s for start in ready]
        after = _starts(page, "after", "virtual", 0.0, FEWER)
        seen["page, right after a run"] = [start.ready_s for start in after]
        cpu["page, right after a run"] = [start.cpu_s for start in after]
        if os.name == "posix":  # the simulated stage needs a pseudo-terminal
            real = _starts(page, "real", "real", _SETTLED_S, FEWER)
            seen["page, simulated rig in real time"] = [start.ready_s for start in real]
            cpu["page, simulated rig in real time"] = [start.cpu_s for start in real]
        seen["labrig run, simulated rig"] = _by_command(folder)
    steps = {
        text: statistics.median(start.steps.get(text, 0.0) for start in ready)
        for text in ready[0].steps
    }
    rows = tuple(
        (
            name,
            f"{statistics.median(times):.2f} s",
            f"{max(times):.2f} s",
            f"{statistics.median(cpu[name]):.2f} s" if name in cpu else "",
            f"{len(times)}",
        )
        for name, times in seen.items()
    )
    return Report(
        tables=(
            Table(
                "From the click until ready",
                ("", "median", "longest", "CPU, median", "starts"),
                rows,
            ),
            Table(
                "Step by step (page, simulated rig, median)",
                ("step", "takes"),
                tuple((text, f"{1e3 * took_s:.0f} ms") for text, took_s in steps.items()),
            ),
        ),
        figures={"ready_s": seen, "cpu_s": cpu, "steps_s": steps, "limit_s": LIMIT_S},
        notes=(f"the limit is {LIMIT_S:g} s for the page on the simulated rig", note),
    )
