"""The page of one session's result: curves, forces, models, B and EIBM, the verdict."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query
from fastapi.responses import HTMLResponse, Response

from labrig.analysis.results import reading_curve
from labrig.panel.core.file_names import existing
from labrig.panel.core.requests import Here
from labrig.panel.errors import MissingError
from labrig.panel.pages._result_cache import ResultCache, as_text
from labrig.panel.pages._result_data import beside, measured_of, measured_result
from labrig.panel.pages._sessions import SUFFIX, Session
from labrig.panel.pages.interface import NOWHERE, PanelPage, own_script

router = APIRouter(prefix="/api/result")
# The report is a file of its own: it may draw itself, and neither run scripts nor load anything.
_REPORT_POLICY = "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:"


@router.get("")
def result(panel: Here, session: Session, measured: bool = False) -> Response:
    """Return a session's result; with `measured` at once, without models if they are not kept."""
    path = existing(panel.settings.data, session, SUFFIX)
    cache, data = panel.state(ResultCache), panel.settings.data
    text = cache.kept(data, path)
    if text is None and measured:
        text = as_text(measured_result(path, session))
    if text is None:
        text = cache.computed(data, path, session)
    return Response(text, media_type="application/json")


@router.get("/reading")
def reading(
    panel: Here,
    session: Session,
    condition: Annotated[int, Query(ge=0)],
    index: Annotated[int, Query(ge=0)],
) -> Any:
    """Return the curve of one reading's image, null where it has none."""
    path = existing(panel.settings.data, session, SUFFIX)
    measurements, _ = measured_of(path)
    return {"curve": reading_curve(measurements, condition, index)}


@router.get("/report")
def report(panel: Here, session: Session) -> HTMLResponse:
    """Return the report beside the session."""
    path = existing(panel.settings.data, session, SUFFIX)
    file = beside(path, ".report.html")
    if not file.is_file():
        raise MissingError(f"{file.name} is not written yet; press Report.")
    headers = {"Content-Security-Policy": _REPORT_POLICY}
    return HTMLResponse(file.read_bytes(), headers=headers)


PAGE = PanelPage(
    title="Result", order=51.5, modes=NOWHERE, router=router, script=own_script("result")
)
