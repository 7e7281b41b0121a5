"""The page of two sessions side by side."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter

from labrig.files import SESSION_ENDINGS
from labrig.library import compare_means
from labrig.panel.core.file_names import existing
from labrig.panel.core.requests import Here
from labrig.panel.pages._sessions import Session, entry_of, shown
from labrig.panel.pages.interface import NOWHERE, PanelPage, own_script
from labrig.session import open_session

router = APIRouter(prefix="/api/library")


@router.get("/compare")
def compare(panel: Here, a: Session, b: Session) -> Any:
    """Two sessions side by side."""
    data = panel.settings.data
    first, second = existing(data, a, *SESSION_ENDINGS), existing(data, b, *SESSION_ENDINGS)
    with open_session(first, live=True) as left, open_session(second, live=True) as right:
        rows = compare_means(left, right)
    return {
        "a": shown(entry_of(panel, first, a)),
        "b": shown(entry_of(panel, second, b)),
        "rows": rows,
    }


PAGE = PanelPage(
    title="Compare", order=52, modes=NOWHERE, router=router, script=own_script("compare")
)
