"""The page of all sessions in the data folder: find, sort, choose."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query, Request

from labrig.files import SESSION_ENDINGS
from labrig.library import CatalogueEntry, SessionQuery
from labrig.panel.core.file_names import existing
from labrig.panel.core.panel import Panel
from labrig.panel.core.requests import Here, Name, RequestModel
from labrig.panel.pages._sessions import REFRESH_S, shown
from labrig.panel.pages.interface import PanelPage, own_script
from labrig.session import is_left_by_a_crash, recover

router = APIRouter(prefix="/api/library")
Short = Annotated[str, Query(max_length=200)]


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
    """Return the sessions that fit."""
    library = panel.library
    pending = library.refresh(REFRESH_S)
    wanted = SessionQuery(
        sort=sort, down=down, text=text, outcome=outcome, sheet=sheet, limit=limit, offset=offset
    )
    found = library.find(wanted)
    return {
        "sessions": [
            {**shown(entry), "recoverable": _is_recoverable(panel, entry)}
            for entry in found.entries
        ],
        "total": found.total,
        "damaged": library.damaged(),
        "pending": pending,
        "cut": library.cut.replace(f"{panel.settings.data}: ", ""),
    }


class RecoverBody(RequestModel):
    """A session that a crash has left."""

    name: Name


@router.post("/recover")
def recover_session(request: Request, body: RecoverBody, panel: Here) -> Any:
    """Write what can be saved to a file beside the session, as `labrig recover`."""
    who = panel.acting(request)
    data = panel.settings.data
    report = recover(existing(data, body.name, *SESSION_ENDINGS))
    output = None if report.output is None else report.output.relative_to(data).as_posix()
    if output is not None:
        panel.actions.add(who, f"recovered {body.name} as {output}")
    plain = [text.replace(f"{data}/", "") for text in (report.text, *report.notes)]
    return {"output": output, "text": plain[0], "notes": plain[1:]}


def _is_recoverable(panel: Panel, entry: CatalogueEntry) -> bool:
    return entry.error is not None and is_left_by_a_crash(panel.settings.data / entry.name)


PAGE = PanelPage(
    title="Sessions",
    order=50,
    opens=frozenset({"sessions"}),
    router=router,
    script=own_script("library"),
)
