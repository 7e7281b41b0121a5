"""The page of all sessions in the data folder: find, sort, choose."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query

from labrig.library import select
from labrig.panel.core.requests import Here
from labrig.panel.pages._sessions import REFRESH_S, shown
from labrig.panel.pages.interface import PanelPage, own_script

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
    entries = library.entries()
    found = select(entries, sort=sort, down=down, text=text, outcome=outcome, sheet=sheet)
    return {
        "sessions": [shown(entry) for entry in found[offset : offset + limit]],
        "total": len(found),
        "damaged": sum(entry.error is not None for entry in entries),
        "pending": pending,
    }


PAGE = PanelPage(
    title="Sessions",
    order=50,
    opens=frozenset({"sessions"}),
    router=router,
    script=own_script("library"),
)
