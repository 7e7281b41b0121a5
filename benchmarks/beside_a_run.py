"""How late the edges of a run are, alone and beside what the panel computes meanwhile.

Runs on the simulated boards' own sockets, in real time, started by the panel: three positions of 29
edges each, whose prompts are answered at once, so that the live fit has no time of its own. In
turns: nothing beside it (no live fit), the live fit, and diagnoses of a finished session one after
the other besides. Late: the moment an edge was written (the middle between the request and the
board's answer) after it was due; an edge more than 5 ms late spoils its reading.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import threading
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.report import Report, Table, busy, load
from labrig.config.templates import write_templates
from labrig.session import open_session
from tests.labrig.panel.page import TOO_BUSY, Page, Server

ROUNDS = 2
SPOILT_S = 5e-3
_TRIES = 6
_PROTOCOL = """
moisten = false
[pulse_train]
zero_readings = 2
pulse_s = 0.3
sample_at_s = 0.25
half_window_s = 0.04
readings_per_voltage = 13
[[places]]
configuration = "long"
positions_mm = [5, 10, 15]
[extras]
mode = "paper"
"""
_WITHOUT_FIT = (
    "from labrig.panel.analysis.live_fit import LiveFit; LiveFit._take = lambda *a: None; "
    "import sys; from labrig.__main__ import main; sys.exit(main())"
)
CASES = ("nothing", "the live fit", "the live fit and diagnoses")


@dataclass
class Seen:
    """What the runs of one case were like."""

    runs_s: list[np.ndarray] = field(default_factory=list)  # lateness of each edge
    asked_s: list[np.ndarray] = field(default_factory=list)  # until the board was asked
    loads: list[float] = field(default_factory=list)
    broken: list[str] = field(default_factory=list)
    invalid: int = 0
    readings: int = 0

    def row(self, what: str) -> tuple[str, ...]:
        """For the table."""
        late = np.concatenate(self.runs_s) if self.runs_s else np.full(1, np.nan)
        asked = np.concatenate(self.asked_s) if self.asked_s else np.full(1, np.nan)
        return (
            what,
            f"{len(late)}",
            f"{1e3 * np.median(asked):.2f} ms",
            f"{1e3 * asked.max():.1f} ms",
            f"{1e3 * np.median(late):.2f} ms",
            f"{1e3 * np.percentile(late, 99):.1f} ms",
            f"{1e3 * late.max():.1f} ms",
            f"{int((late > SPOILT_S).sum())}",
            f"{self.invalid} of {self.readings}",
            f"{len(self.broken)}",
            f"{np.mean(self.loads):.1f}" if self.loads else "",
        )


class _WithoutFit(Server):
    """A panel whose live fit hears nothing."""

    def __init__(self, rig: Path) -> None:
        popen = subprocess.Popen
        command = [sys.executable, "-c", _WITHOUT_FIT]
        try:
            subprocess.Popen = (
                lambda given, **more: popen(  # type: ignore[misc, assignment]
                    command + given[3:], **more
                )
            )
            super().__init__(rig)
        finally:
            subprocess.Popen = popen  # type: ignore[misc]


def _run(page: Page, name: str) -> str:
    """One run to its end; how it ended when it was not completed."""
    body = {"protocol": "p.toml", "sheet": "sheet.toml", "session": name, "clock": "real"}
    job = page.do("/api/run", **body)
    page.until(lambda m: m["type"] == "job" and m["id"] == job["id"])
    answered: set[int] = set()
    while not (
        ends := [m for m in page.of("job") if m["id"] == job["id"] and m["state"] != "going"]
    ):
        for prompt in page.of("prompt"):
            if prompt["prompt"] not in answered:
                answered.add(prompt["prompt"])
                page.ask("POST", "/api/answer", {"prompt": prompt["prompt"], "done": True})
        threading.Event().wait(0.05)
    return "" if ends[-1].get("code") == 0 else str(ends[-1]["text"])


def _ends(page: Page, job_id: str) -> list[dict[str, Any]]:
    return [m for m in page.of("job") if m["id"] == job_id and m["state"] != "going"]


def _note(seen: Seen, path: Path) -> None:
    with open_session(path) as session:
        for run in session.runs:
            writes, readings = run.writes, run.readings
            middle_s = 0.5 * (writes["before_s"] + writes["after_s"])
            seen.runs_s.append(middle_s - writes["due_s"])
            seen.asked_s.append(writes["before_s"] - writes["due_s"])
            seen.invalid += int((~readings["valid"]).sum())
            seen.readings += len(readings)
    seen.loads.append(load() or 0.0)


class _Diagnoses:
    """Keeps one diagnosis of a session going on."""

    def __init__(self, page: Page, session: str) -> None:
        self._page, self._session = page, session
        self._ended = threading.Event()
        self.thread = threading.Thread(target=self._go_on, daemon=True)
        self.thread.start()

    def _go_on(self) -> None:
        while not self._ended.wait(0.2):
            self._page.ask(
                "POST", "/api/analysis/start", {"kind": "diagnose", "session": self._session}
            )  # refused while one is going on

    def end(self) -> None:
        """And the one that is going on."""
        self._ended.set()
        self.thread.join()
        for job in self._page.ask("GET", "/api/analysis")[1]["jobs"]:
            if job["state"] in ("queued", "running"):
                self._page.ask("POST", "/api/analysis/cancel", {"id": job["id"]})


def _case(folder: Path, case: str, number: int, seen: Seen) -> None:
    server = (_WithoutFit if case == CASES[0] else Server)(folder / "rig.toml")
    page = Page(server)
    page.take_control(force=True)
    beside = None
    try:
        for attempt in range(_TRIES):
            name = f"{case.replace(' ', '-')}-{number}-{attempt}.h5"
            if case == CASES[2] and beside is None:
                beside = _Diagnoses(page, "finished.h5")
                threading.Event().wait(5.0)
            why = _run(page, name)
            if not why:
                _note(seen, folder / name)
                return
            if TOO_BUSY not in why:
                seen.broken.append(why)
    finally:
        if beside is not None:
            beside.end()
        page.close()
        server.end()


def _finished(folder: Path) -> None:
    """A session to diagnose: the shipped one."""
    files = [str(folder / f"{one}.toml") for one in ("rig", "protocol", "sheet")]
    command = [sys.executable, "-m", "labrig", "run", *files, "--yes", "-o"]
    subprocess.run([*command, str(folder / "finished.h5")], check=True, capture_output=True)


def measure() -> Report:
    """Measure all cases in turns."""
    note = busy()
    found = {case: Seen() for case in CASES}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "rig"
        write_templates(folder, simulated=True)
        (folder / "p.toml").write_text(_PROTOCOL)
        _finished(folder)
        for number in range(ROUNDS):
            for case in CASES:
                _case(folder, case, number, found[case])
    columns = (
        "beside the run", "edges", "asked, median", "largest", "written, median", "99 %",
        "largest", "later than 5 ms", "readings invalid", "broken off", "load",
    )  # fmt: skip
    rows = tuple(seen.row(case) for case, seen in found.items())
    figures: dict[str, Any] = {
        case: {
            "late_s": [run.tolist() for run in seen.runs_s],
            "asked_late_s": [run.tolist() for run in seen.asked_s],
            "broken_off": seen.broken,
            "load": seen.loads,
        }
        for case, seen in found.items()
    }
    broken = [f"broken off: {why}" for seen in found.values() for why in seen.broken]
    return Report((Table("Late edges", columns, rows),), figures, (*broken, note))
