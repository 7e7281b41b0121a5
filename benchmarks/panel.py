"""The panel: images and trace updates a second on the screen, their latency, and their cost.

A run on the simulated boards' own sockets, in real time; pages in headless browsers, which draw
without a graphics card on the same cores. Beside each page's figures stand those of a bare page, in
the same run and as many of them: it decodes and draws the images at the same size, acknowledges
them, and does nothing else. Clients that only receive show what the server itself can.
"""

from __future__ import annotations

import statistics
import tempfile
from dataclasses import dataclass
from pathlib import Path

from benchmarks._panel_pages import Seen, bare_pages, browsers, full_pages, receivers, running
from benchmarks.report import Report, Table, busy, load
from tests.panel_browser.rig_world import rig_world

MEASURED_S = 8.0
CLIENTS = (1, 5)
AIM = {"images": 25.0, "updates": 30.0, "images_of_5": 20.0, "latency_s": 0.150}


@dataclass(frozen=True)
class Row:
    """What the clients of one measurement saw, and the load of the machine meanwhile."""

    what: str
    seen: Seen
    load: float
    share: float | None = None  # of the images that as many bare pages drew

    def cells(self) -> tuple[str, ...]:
        """For the table."""
        seen, late = self.seen, self.seen.latencies_s
        return (
            self.what,
            str(seen.clients),
            f"{min(seen.images_hz):.1f}",
            "" if self.share is None else f"{100 * self.share:.0f} %",
            f"{min(seen.updates_hz):.1f}" if seen.updates_hz else "",
            f"{1e3 * statistics.median(late):.0f} ms" if late else "",
            f"{1e3 * statistics.quantiles(late, n=20)[-1]:.0f} ms" if len(late) > 1 else "",
            *(f"{100 * seen.cpu.get(name, 0):.0f} %" for name in ("server", "curves", "run")),
            f"{self.load:.1f}",
        )


def measure() -> Report:
    """Run it."""
    note = busy()
    rows = [row for count in CLIENTS for row in _measured(count)]
    columns = (
        "who looks", "how many", "images/s", "of bare pages", "trace updates/s",
        "exposure to screen, median", "95 %", "server", "curves", "run", "load",
    )  # fmt: skip
    made = "25 images/s made, three traces of 1000 samples/s"
    table = Table(made, columns, tuple(row.cells() for row in rows))
    figures = {f"{row.what}_{row.seen.clients}".replace(" ", "_"): _figures(row) for row in rows}
    return Report(
        (table,),
        {**figures, "aim": AIM},
        (
            "images/s, trace updates/s: of the client that got fewest; an update is of all traces",
            "of bare pages: images/s as a share of those of as many pages that only draw images",
            "server, curves, run: share of one core; curves: what finds the sheet in the images",
            "exposure to screen: from the frame's time stamp to the next frame of the browser",
            "load: mean number of processes that wanted a core in the last minute, ours included",
            note,
        ),
    )


def _figures(row: Row) -> dict[str, object]:
    late = row.seen.latencies_s
    return {
        "images_hz": row.seen.images_hz,
        "share_of_bare": row.share,
        "updates_hz": row.seen.updates_hz,
        "latency_median_s": statistics.median(late) if late else None,
        "oldest_s": max(late, default=None),
        "cpu": row.seen.cpu,
        "load": row.load,
    }


def _measured(count: int) -> list[Row]:
    """Receivers, bare pages and full pages in turn, all of them in one run."""
    with (
        tempfile.TemporaryDirectory() as folder,
        rig_world(Path(folder) / "rig") as world,
        running(world),
        browsers() as visit,
    ):
        received = Row("receiver", receivers(world, count, MEASURED_S), _load())
        bare = [bare_pages(world, visit, count, MEASURED_S)]
        full = full_pages(world, visit, count, MEASURED_S)
        full_load = _load()
        bare.append(bare_pages(world, visit, count, MEASURED_S))
    drawn = [min(seen.images_hz) for seen in bare]
    share = min(full.images_hz) / statistics.mean(drawn)
    return [
        received,
        Row("bare page", _joined(bare), _load()),
        Row("page", full, full_load, share),
    ]


def _joined(before_and_after: list[Seen]) -> Seen:
    """The mean of the two measurements, so that a change of the load hits both alike."""
    first, last = before_and_after
    return Seen(
        clients=first.clients,
        images_hz=[statistics.mean([min(first.images_hz), min(last.images_hz)])],
        updates_hz=[],
        latencies_s=first.latencies_s + last.latencies_s,
        cpu={name: 0.5 * (first.cpu.get(name, 0) + last.cpu.get(name, 0)) for name in first.cpu},
    )


def _load() -> float:
    return load() or 0.0
