"""The page of one session: its facts, runs and log, and its export."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from fastapi.responses import FileResponse
from pydantic import Field
from starlette.background import BackgroundTask

from labrig.errors import BadInputError
from labrig.files import SESSION_ENDINGS, write_zip
from labrig.panel.core.file_names import existing
from labrig.panel.core.requests import Here, Name, RequestModel
from labrig.panel.pages._sessions import REFRESH_S, Session, entry_of, shown
from labrig.panel.pages.interface import NOWHERE, PanelPage, own_script
from labrig.report.tables.about import about_tables
from labrig.report.tables.devices import devices_as_table
from labrig.report.tables.overview import overview
from labrig.session import Mark, RecordedSession, add_mark, export_session, open_session
from labrig.session.format import layout
from labrig.session.marks.mark import named

router = APIRouter(prefix="/api/library")
_MOST_LOG = 5000


@router.get("/session")
def one(panel: Here, name: Session) -> Any:
    """One session, its runs and its log."""
    path = existing(panel.settings.data, name, *SESSION_ENDINGS)
    pending = panel.library.refresh(REFRESH_S)  # a fit may have been written since
    entry = entry_of(panel, path, name)
    with open_session(path, live=True) as session:
        found, stated = overview(session), session.about
        log = log_of(session)
    stated_as = [*about_tables(stated), *map(devices_as_table, filter(None, [found.devices]))]
    about = [{"title": t.title, "columns": t.columns, "rows": t.rows} for t in stated_as]
    return {
        **shown(entry),
        "runs_table": list(found.runs),
        "devices": list(found.devices),
        "marks_table": [mark.as_dict() for mark in found.marks],
        "about": about,
        "pending": pending,
        "log": log,
    }


class MarkAfterEndBody(RequestModel):
    """A reading, or a whole run, of a closed session that is invalid; or that taken back."""

    name: Name
    run: int = Field(ge=0)
    reading: int | None = Field(None, ge=0)
    why: str = Field(min_length=1, max_length=200)
    undo: bool = False


@router.post("/mark")
def add(request: Request, body: MarkAfterEndBody, panel: Here) -> Any:
    """Mark a reading or run invalid, or take that back; the recording stays as it is."""
    who = panel.acting(request)
    path = existing(panel.settings.data, body.name, *SESSION_ENDINGS)
    why = " ".join(body.why.split())
    name = layout.cut(who, layout.MARK_WHO_BYTES).decode("utf-8")
    add_mark(
        path, Mark(run=body.run, reading=body.reading, why=why, who=name, invalid=not body.undo)
    )
    panel.library.refresh(REFRESH_S)
    which = named(body.run, body.reading)
    did = f"took back the mark of {which}" if body.undo else f"marked {which} invalid"
    panel.log(who, f"{did} in {body.name}: {why}", note=False)
    return {"ok": True}


def log_of(session: RecordedSession) -> list[dict[str, Any]]:
    """Return a session's log, its times since the session's start, by the session's own clock."""
    return [
        {
            "time_s": round(event.time_s - session.began_s, 6),
            "kind": event.kind,
            "run": event.run if event.run >= 0 else None,
            "text": " ".join(part for part in (event.subject, event.text) if part) or event.kind,
        }
        for event in session.events[-_MOST_LOG:]
    ]


@router.get("/export")
def export(
    panel: Here, name: Session, kind: Annotated[str, Query(alias="as")] = "h5"
) -> FileResponse:
    """Return the file itself, or the tables of its measurements as a zip."""
    path = existing(panel.settings.data, name, *SESSION_ENDINGS)
    if kind == "h5":
        with open_session(path):  # one that is being recorded is not whole
            pass
        return FileResponse(path, media_type="application/x-hdf5", filename=path.name)
    if kind != "csv":
        raise BadInputError(f"as={kind[:20]!r}: h5 or csv is possible.")
    folder = Path(tempfile.mkdtemp(prefix="labrig-export-"))
    try:
        export_session(path, folder / path.stem)
        tables = sorted(each for each in (folder / path.stem).rglob("*") if each.is_file())
        packed = folder / "export.zip"
        write_zip(packed, {each: each.relative_to(folder).as_posix() for each in tables})
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
