"""Write table, summary and figures of a batch."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from labrig.batch.contract import BatchTask
from labrig.batch.plan import ROWS
from labrig.batch.rows import LastRows
from labrig.batch.summary.numbers import BatchSummary, summary_of
from labrig.batch.table import write_csv, write_parquet
from labrig.files import write_text
from labrig.serialise import finite


@dataclass(frozen=True)
class Written:
    """What was made of the rows."""

    summary: BatchSummary
    paths: tuple[Path, ...]
    notes: tuple[str, ...]  # a sentence for each thing that could not be made


def write_summary(folder: Path, names: Sequence[str], task: BatchTask) -> Written:
    """Write the table of the rows of these names, and what they say. Raises LabrigError."""
    rows = LastRows(folder / ROWS, names)
    paths, notes = [folder / "table.csv"], []
    write_csv(folder / "table.csv", rows)
    if write_parquet(folder / "table.parquet", rows):
        paths.append(folder / "table.parquet")
    summary = summary_of(task, rows)
    text = json.dumps(finite(summary.to_json()), indent=1, ensure_ascii=False) + "\n"
    write_text(folder / "summary.json", text)
    paths.append(folder / "summary.json")
    try:
        from labrig.batch.summary.figures import draw_summary

        paths += draw_summary(summary, folder)
    except ImportError:
        notes.append("there are no figures: matplotlib is not installed.")
    return Written(summary, tuple(paths), tuple(notes))
