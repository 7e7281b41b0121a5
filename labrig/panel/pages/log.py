"""The page of actions: who did what at the panels of this data folder."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter

from labrig.panel.core.requests import Here
from labrig.panel.pages.interface import PanelPage, own_script

MOST_ACTIONS = 2000
router = APIRouter(prefix="/api")


@router.get("/log")
def log(panel: Here, limit: int = 200) -> Any:
    """Return the newest actions, newest last."""
    return {"actions": panel.actions.last(max(1, min(limit, MOST_ACTIONS)))}


PAGE = PanelPage(title="Log", order=60, router=router, script=own_script("log"))
