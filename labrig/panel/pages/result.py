"""The page of one session's result: curves, forces, models, B and EIBM, the verdict."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Query
from fastapi.responses import Response

from labrig.analysis.results import reading_curve
from labrig.files import SESSION_ENDINGS
from labrig.panel.core.file_names import existing
from labrig.panel.core.panel import Panel
from labrig.panel.core.requests import Here
from labrig.panel.pages._result_cache import ResultCache, as_text, state_of
from labrig.panel.pages._result_data import beside, measured_of, measured_result
from labrig.panel.pages._sessions import Session
from labrig.panel.pages.interface import NOWHERE, PanelPage, own_script
from labrig.session import open_session
from model import Measurements
from protocols.execution.events import Outcome

Stage = Literal["measured", "fitted", "settled"]
router = APIRouter(prefix="/api/result")


@router.get("")
def result(panel: Here, session: Session, upto: Stage = "settled") -> Response:
    """Return a session's result; up to a stage that takes less time, where it is not kept whole."""
    path = existing(panel.settings.data, session, *SESSION_ENDINGS)
    cache, data = panel.state(ResultCache), panel.settings.data
    text = _live(panel, path, session) or cache.kept(data, path)
    if text is None and upto == "measured":
        cache.prepare()
        text = as_text(measured_result(path, session))
    elif text is None and upto == "fitted":
        text = cache.fitted(path, session)
    elif text is None:
        text = cache.computed(data, path, session)
    return Response(text, media_type="application/json")


@router.get("/settling")
def settling(panel: Here, session: Session) -> Response:
    """Return how B and EIBM settle, as far as it is computed: ask again until it is complete."""
    path = existing(panel.settings.data, session, *SESSION_ENDINGS)
    text = panel.state(ResultCache).settling(panel.settings.data, path, session)
    return Response(text, media_type="application/json")


def _live(panel: Panel, path: Path, session: str) -> str | None:
    """Return the live fit of a run that goes on, or has ended and is not analysed yet."""
    live = panel.live_fit.result(session)
    if live is None:
        return None
    with open_session(path, live=True) as opened:
        if opened.has_measurements:
            return None
        missing = list(_missing_of_live(path, grows=opened.outcome is Outcome.RUNNING))
    return json.dumps({**live, "missing": missing, "complete": True, "live": True}, allow_nan=False)


def _missing_of_live(path: Path, *, grows: bool) -> Iterator[dict[str, str]]:
    if grows:
        yield {"kind": "report", "text": "Report needs a run that has ended."}
        return
    text = (
        f"{path.name} is not analysed yet: this is the live fit, as far as it has come. "
        "Analyse measures everything."
    )
    yield {"kind": "analyze", "text": text}
    file = beside(path, ".report.html").name
    yield {"kind": "report", "text": f"There is no {file} yet. Report writes it."}


@router.get("/reading")
def reading(
    panel: Here,
    session: Session,
    condition: Annotated[int, Query(ge=0)],
    index: Annotated[int, Query(ge=0)],
) -> Any:
    """Return the curve of one reading's image, null where it has none."""
    path = existing(panel.settings.data, session, *SESSION_ENDINGS)
    return {"curve": reading_curve(_measurements(path, state_of(path)), condition, index)}


@lru_cache(maxsize=1)
def _measurements(path: Path, state: str) -> Measurements:  # noqa: ARG001 - a part of the key
    """Return the measurements of the session whose readings are leafed through."""
    return measured_of(path).measurements


PAGE = PanelPage(
    title="Result", order=51.5, modes=NOWHERE, router=router, script=own_script("result")
)
