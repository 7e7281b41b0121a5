"""The files that analysis writes beside a session."""

from __future__ import annotations

import datetime as dt
from pathlib import Path

from labrig.files import discard

ENDINGS = {
    "model": ".model.toml",  # of fit: constant EIBM
    "completed_model": ".model+.toml",  # of diagnose: with the effects that it found
    "diagnosis": ".diagnosis.json",
    "report": ".report.html",
    "figures": ".figures.zip",  # of report: as PDF and SVG
    "next": ".next.toml",  # a protocol.toml
}


def output_path(session: Path, name: str) -> Path:
    """Return where an output of a session lies."""
    return session.with_name(session.stem + ENDINGS[name])


def outputs_of(session: Path) -> dict[str, dict[str, str]]:
    """Return name and time of each output that is there, whoever has written it."""
    found = {name: output_path(session, name) for name in ENDINGS}
    return {
        name: {"file": path.name, "wall": _changed(path)}
        for name, path in found.items()
        if path.is_file()
    }


def discard_unfinished(session: Path, pid: int) -> None:
    """Remove what a process that was ended has left beside a session."""
    discard(session.with_name(f"{session.name}.{pid}.new"))
    for name in ENDINGS:
        path = output_path(session, name)
        discard(path.with_name(path.name + ".part"))


def _changed(path: Path) -> str:
    changed = dt.datetime.fromtimestamp(path.stat().st_mtime, dt.UTC)
    return changed.isoformat(timespec="seconds")
