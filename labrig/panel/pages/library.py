"""The sessions of the data folder: list, open, compare, export."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, Query
from fastapi.responses import FileResponse
from starlette.background import BackgroundTask

from labrig.errors import BadInputError
from labrig.library import CatalogueEntry, compare_means, read_entry, select
from labrig.panel.pages.file_names import existing
from labrig.panel.pages.run import Here
from labrig.panel.server.panel import Panel
from labrig.report.tables.overview import overview
from labrig.session import export_session, open_session

router = APIRouter(prefix="/api/library")
SUFFIX = ".h5"
_BUDGET_S = 1.0  # to look at files that have changed; the page asks again while some are left
_MOST_LOG = 5000
Short = Annotated[str, Query(max_length=200)]
Session = Annotated[str, Query(max_length=400)]


@router.get("")
def listed(
    panel: Here,
    sort: Short = "started",
    down: bool = True,
    text: Short = "",
    outcome: Short = "",
    sheet: Short = "",
    limit: Annotated[int, Query(ge=1, le=2000)] = 200,
    offset: Annotated[int, Query(ge=0)] = 0,
) -> Any:
    """The sessions that fit."""
    library = panel.library
    pending = library.refresh(_BUDGET_S)
    entries = library.entries()
    found = select(entries, sort=sort, down=down, text=text, outcome=outcome, sheet=sheet)
    return {
        "sessions": [_shown(entry) for entry in found[offset : offset + limit]],
        "total": len(found),
        "damaged": sum(entry.error is not None for entry in entries),
        "pending": pending,
    }


@router.get("/session")
def one(panel: Here, name: Session) -> Any:
    """One session, its runs and its log."""
    path = existing(panel.settings.data, name, SUFFIX)
    entry = _entry(panel, path, name)
    with open_session(path, live=True) as session:
        found = overview(session)
        log = [
            {"time_s": e.time_s, "kind": e.kind, "run": e.run if e.run >= 0 else None,
             "text": " ".join(part for part in (e.subject, e.text) if part)}
            for e in session.events[-_MOST_LOG:]
        ]  # fmt: skip
    return {**_shown(entry), "runs_table": list(found.runs), "log": log}


@router.get("/compare")
def compare(panel: Here, a: Session, b: Session) -> Any:
    """Two sessions side by side."""
    data = panel.settings.data
    first, second = existing(data, a, SUFFIX), existing(data, b, SUFFIX)
    with open_session(first, live=True) as left, open_session(second, live=True) as right:
        rows = compare_means(left, right)
    return {
        "a": _shown(_entry(panel, first, a)),
        "b": _shown(_entry(panel, second, b)),
        "rows": rows,
    }


@router.get("/export")
def export(
    panel: Here, name: Session, kind: Annotated[str, Query(alias="as")] = "h5"
) -> FileResponse:
    """The file itself, or the tables of its measurements as a zip."""
    path = existing(panel.settings.data, name, SUFFIX)
    if kind == "h5":
        with open_session(path):  # one that is being recorded is not whole
            pass
        return FileResponse(path, media_type="application/x-hdf5", filename=path.name)
    if kind != "csv":
        raise BadInputError(f"as={kind[:20]!r}: h5 or csv is possible.")
    folder = Path(tempfile.mkdtemp(prefix="labrig-export-"))
    try:
        export_session(path, folder / path.stem)
        packed = shutil.make_archive(str(folder / "export"), "zip", folder, path.stem)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    return FileResponse(
        packed,
        media_type="application/zip",
        filename=f"{path.stem}.zip",
        background=BackgroundTask(shutil.rmtree, folder, ignore_errors=True),
    )


def _entry(panel: Panel, path: Path, name: str) -> CatalogueEntry:
    """As the library knows it, with its fit; looked up now where it does not."""
    known = next((entry for entry in panel.library.entries() if entry.name == name), None)
    return known or read_entry(path, name)


def _shown(entry: CatalogueEntry) -> dict[str, Any]:
    plain = entry.as_dict()
    del plain["checksum"]
    return plain
