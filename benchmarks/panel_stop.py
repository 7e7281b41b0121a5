"""STOP under load: from the press to 0 V, by the simulated world's own record.

Each press is of a run on the simulated boards' own sockets, in the middle of a pulse, while 200
silent connections are open and 8 threads flood, at the panel's port and at that of the STOP
process. Beside them the same presses without any load.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections import Counter
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

from benchmarks.report import Report, Table, busy
from tests.labrig.panel.load import flood, silent
from tests.labrig.panel.page import Page
from tests.panel_browser.rig_world import RigWorld, energised_page, rig_world

SILENT = 200
PRESSES = 3  # of each kind
AIM_S = 0.2
_END_S = 60.0
_ENDED = frozenset({"ended", "lost"})


@dataclass(frozen=True)
class Press:
    """One press, and what was answered to others meanwhile."""

    gone_s: float  # to 0 V
    answered_s: float
    status: int
    others: Counter[str]


def measure() -> Report:
    """Run it."""
    note = busy()
    with tempfile.TemporaryDirectory() as folder, rig_world(Path(folder) / "rig") as world:
        found = {
            (where, loaded): [_pressed(world, where, loaded, k) for k in range(PRESSES)]
            for where in ("STOP process", "panel")
            for loaded in (False, True)
        }
    columns = (
        "pressed at", "load", "to 0 V, median", "worst", "answer, median", "presses refused",
        "others answered", "of them refused",
    )  # fmt: skip
    rows = tuple(_row(where, loaded, presses) for (where, loaded), presses in found.items())
    figures = {
        f"{where} {'loaded' if loaded else 'idle'}".replace(" ", "_"): {
            "gone_s": [press.gone_s for press in presses],
            "answered_s": [press.answered_s for press in presses],
        }
        for (where, loaded), presses in found.items()
    }
    notes = (
        f"load: {SILENT} silent connections and a flood of requests without a token at each port",
        f"aim: below {1e3 * AIM_S:.0f} ms, no press refused",
        note,
    )
    return Report((Table("STOP in the middle of a pulse", columns, rows),), figures, notes)


def _row(where: str, loaded: bool, presses: list[Press]) -> tuple[str, ...]:
    others: Counter[str] = sum((press.others for press in presses), Counter())
    gone = [press.gone_s for press in presses]
    return (
        where,
        "yes" if loaded else "no",
        f"{1e3 * statistics.median(gone):.0f} ms",
        f"{1e3 * max(gone):.0f} ms",
        f"{1e3 * statistics.median(press.answered_s for press in presses):.0f} ms",
        f"{sum(press.status != 200 for press in presses)} of {len(presses)}",
        str(others.total()),
        str(sum(count for status, count in others.items() if status in {"401", "403", "429"})),
    )


def _pressed(world: RigWorld, where: str, loaded: bool, number: int) -> Press:
    session = f"{where[:4].strip()}-{'loaded' if loaded else 'idle'}-{number}.h5"
    page = energised_page(world, session)
    stop = urlsplit(page.hello["stop_url"]).netloc
    doors = {"panel": (world.netloc, "/api/stop"), "STOP process": (stop, "/stop")}
    floods = []
    with ExitStack() as load:
        for netloc, path in doors.values() if loaded else ():
            load.enter_context(silent(netloc, SILENT))
            floods.append(load.enter_context(flood(netloc, path)))
        pressed_s = time.perf_counter()
        netloc, path = doors[where]
        status, _ = world.server.ask("POST", path, {}, netloc=netloc)
        answered_s = time.perf_counter() - pressed_s
        _wait_for_the_end(page)
    page.close()
    return Press(world.gone_s(pressed_s), answered_s, status, sum(floods, Counter()))


def _wait_for_the_end(page: Page) -> None:
    page.until(lambda m: m["type"] == "job" and m["state"] in _ENDED, _END_S)
