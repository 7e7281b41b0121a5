"""What a benchmark hands back: tables, printed and, with the machine's name, kept as JSON."""

from __future__ import annotations

import datetime as dt
import json
import os
import platform
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).parent / "results"


@dataclass(frozen=True)
class Table:
    """Rows of texts under their headings."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def lines(self) -> list[str]:
        """As Markdown, which is as readable in a terminal."""
        cells = [self.columns, *self.rows]
        widths = [max(len(row[k]) for row in cells) for k in range(len(self.columns))]

        def line(row: tuple[str, ...]) -> str:
            first, *rest = (cell.ljust(w) for cell, w in zip(row, widths, strict=True))
            return "| " + " | ".join([first, *rest]) + " |"

        rule = "|" + "|".join("-" * (width + 2) for width in widths) + "|"
        return [self.title, "", line(self.columns), rule, *(line(row) for row in self.rows), ""]


@dataclass(frozen=True)
class Report:
    """The outcome of one benchmark. `figures` holds the same numbers, SI, for programs."""

    tables: tuple[Table, ...]
    figures: dict[str, Any]
    notes: tuple[str, ...] = field(default=())

    def text(self) -> str:
        """As it is printed."""
        lines = [line for table in self.tables for line in table.lines()]
        return "\n".join([*lines, *(f"- {note}" for note in self.notes)])


def machine() -> dict[str, Any]:
    """Where and when figures were made; how busy the machine was with other things."""
    return {
        "name": platform.node(),
        "cpu": _cpu(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
        "date": dt.datetime.now(dt.UTC).isoformat(timespec="seconds"),
        "load_before": load(),
    }


def load() -> float | None:
    """Processes that want a core, averaged over the last minute; None where nobody counts."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


def busy() -> str:
    """A note on what else the machine does just before a measurement; figures suffer from it."""
    wanting, cores = load(), os.cpu_count()
    if wanting is None:
        return "how busy the machine was with other things is not known"
    return f"before it began {wanting:.1f} processes wanted one of the {cores} cores"


def save(name: str, where: dict[str, Any], report: Report) -> Path:
    """Keep a report as results/NAME.json; returns the path."""
    RESULTS.mkdir(exist_ok=True)
    path = RESULTS / f"{name}.json"
    path.write_text(
        json.dumps({"benchmark": name, "machine": where, **asdict(report)}, indent=1) + "\n",
        encoding="utf-8",
    )
    return path


def _cpu() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
