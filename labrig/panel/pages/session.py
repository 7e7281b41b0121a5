"""The page of one session: its facts, runs and log, and its export."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, Query
from fastapi.responses import FileResponse
from starlette.background import BackgroundTask

from labrig.errors import BadInputError
from labrig.panel.core.file_names import existing
from labrig.panel.core.requests import Here
from labrig.panel.pages._sessions import REFRESH_S, SUFFIX, Session, entry_of, shown
from labrig.panel.pages.interface import NOWHERE, PanelPage, own_script
from labrig.report.tables.about import about_tables
from labrig.report.tables.overview import overview
from labrig.session import export_session, open_session

router = APIRouter(prefix="/api/library")
_MOST_LOG = 5000


@router.get("/session")
def one(panel: Here, name: Session) -> Any:
    """One session, its runs and its log."""
    path = existing(panel.settings.data, name, SUFFIX)
    pending = panel.library.refresh(REFRESH_S)  # a fit may have been written since
    entry = entry_of(panel, path, name)
    with open_session(path, live=True) as session:
        found, stated = overview(session), session.about
        log = [
            {"time_s": e.time_s, "kind": e.kind, "run": e.run if e.run >= 0 else None,
             "text": " ".join(part for part in (e.subject, e.text) if part)}
            for e in session.events[-_MOST_LOG:]
        ]  # fmt: skip
    about = [{"title": t.title, "columns": t.columns, "rows": t.rows} for t in about_tables(stated)]
    return {
        **shown(entry),
        "runs_table": list(found.runs),
        "devices": list(found.devices),
        "log": log,
        "about": about,
        "pending": pending,
    }


@router.get("/export")
def export(
    panel: Here, name: Session, kind: Annotated[str, Query(alias="as")] = "h5"
) -> FileResponse:
    """Return the file itself, or the tables of its measurements as a zip."""
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


PAGE = PanelPage(
    title="Session", order=51, modes=NOWHERE, router=router, script=own_script("session")
)
