"""Runs and readings of a recorded session as columns of numbers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from labrig.session.reading.run_record import RunRecord
from model.measurements import Columns
from model.measurements.columns import of_rows

_READING = ("kind", "step", "time_s", "valid", "why", "frame", "frame_offset_s")


RUN_TABLE = ("run", "sheet", "position mm", "purpose", "state", "valid readings", "frames")


def run_cells(run: RunRecord) -> tuple[str, ...]:
    """Return a run's cells under `RUN_TABLE`."""
    planned = run.planned
    at = "free" if planned.position_m is None else f"{1e3 * planned.position_m:g}"
    state = "completed" if run.completed else "ended early" if run.started else "not begun"
    valid = f"{int(run.readings['valid'].sum())} of {len(run.readings)}" if run.started else "-"
    cells = (str(planned.index + 1), planned.configuration, at, planned.in_words)
    return (*cells, state, valid, str(run.frame_count))


def run_numbers(runs: Iterable[RunRecord]) -> str:
    """Return the numbers of runs in words: "1 to 14, 16". Repeats not begun leave gaps."""
    spans: list[list[int]] = []
    for number in (run.planned.index + 1 for run in runs):
        if spans and number == spans[-1][1] + 1:
            spans[-1][1] = number
        else:
            spans.append([number, number])
    told = (
        f"{first} to {last}" if last > first + 1 else ", ".join(map(str, range(first, last + 1)))
        for first, last in spans
    )
    return ", ".join(told)


def run_columns(runs: Iterable[RunRecord]) -> Columns:
    """Return a row for each run: its place, and how far it came."""
    return of_rows([
        {
            **_place(run), "started": run.started, "completed": run.completed,
            "readings": len(run.readings) if run.started else 0,
            "valid_readings": int(run.readings["valid"].sum()) if run.started else 0,
            "samples": run.samples if run.started else 0, "frames": run.frame_count,
        }
        for run in runs
    ])  # fmt: skip


def reading_columns(runs: Iterable[RunRecord]) -> Columns:
    """Return a row for each reading of the runs that were begun, marks included."""
    return of_rows([row for run in runs if run.started for row in _readings(run)])


def _place(run: RunRecord) -> dict[str, Any]:
    planned = run.planned
    return {
        "run": planned.index, "configuration": planned.configuration,
        "position_m": planned.position_m, "purpose": planned.purpose.value, "extra": planned.extra,
    }  # fmt: skip


def _readings(run: RunRecord) -> Iterator[dict[str, Any]]:
    place = _place(run)
    for row in run.readings:
        plain = {
            name: _plain(row[name])
            for name in row.dtype.names
            if name in _READING or name == "voltage_V"
        }
        yield {**place, "reading": int(row["index"]), **plain, **run.values(row)}


def _plain(value: Any) -> Any:
    return value.item() if hasattr(value, "item") else value
