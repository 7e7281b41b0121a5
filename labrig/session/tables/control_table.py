"""The periods of a session's controllers as control.csv."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from labrig.errors import BadInputError
from labrig.files import write_text
from labrig.session.reading.session import RecordedSession

FILE = "control.csv"
_COLUMNS = {  # of the file: column of the session, factor
    "time_s": ("planned_s", 1.0),
    "reference_mN": ("reference_N", 1e3),
    "force_mN": ("force_N", 1e3),
    "wanted_V": ("wanted_V", 1.0),
    "sheet_V": ("sheet_V", 1.0),
}


def check_no_control(folder: Path) -> None:
    """Raise BadInputError where the file is there already."""
    if (folder / FILE).exists():
        raise BadInputError(f"{folder / FILE} exists already; choose another folder.")


def write_control(session: RecordedSession, folder: Path) -> list[Path]:
    """Write control.csv where a run had a controller; its path."""
    lines = [_line(run.planned.index + 1, row) for run in session.runs for row in run.control]
    if not lines:
        return []
    write_text(folder / FILE, "\n".join([",".join(["run", *_COLUMNS]), *lines]) + "\n")
    return [folder / FILE]


def _line(run: int, row: Any) -> str:
    cells = (f"{factor * float(row[name]):.9g}" for name, factor in _COLUMNS.values())
    return ",".join([str(run), *cells])
