"""Analysis jobs: start, list and cancel them, and open what they have written."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import APIRouter, Query, Request
from fastapi.responses import FileResponse

from labrig.errors import BadInputError
from labrig.files import SESSION_ENDINGS
from labrig.panel.analysis.outputs import ENDINGS, output_path, outputs_of
from labrig.panel.core.control import utc_now
from labrig.panel.core.file_names import existing
from labrig.panel.core.requests import Here, Name, RequestModel
from labrig.panel.errors import MissingError
from labrig.session import open_session

router = APIRouter(prefix="/api/analysis")
WORDS = {
    "analyze": "analysis",
    "fit": "fit",
    "diagnose": "diagnosis",
    "report": "report",
    "next": "proposal of the next measurement",
}
# A report draws itself; it may neither run scripts nor load anything.
REPORT_POLICY = "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:"
MEDIA_TYPES = {
    ".html": "text/html",
    ".json": "application/json",
    ".toml": "text/plain",
    ".zip": "application/zip",
}


class StartBody(RequestModel):
    """What is to be done with a session; `between`: two effects that `next` is to separate."""

    kind: Literal["analyze", "fit", "diagnose", "report", "next"]
    session: Name
    between: tuple[Name, Name] | None = None


class CancelBody(RequestModel):
    """Which job."""

    id: str


@router.get("")
def listed(panel: Here) -> Any:
    """Return all analysis jobs of this panel, newest last."""
    return panel.analysis_jobs.message()


@router.post("/start")
def start(request: Request, body: StartBody, panel: Here) -> Any:
    """Queue a job."""
    who = panel.acting(request)
    if body.between is not None and body.kind != "next":
        raise BadInputError("between is for next only.")
    path = existing(panel.settings.data, body.session, *SESSION_ENDINGS)
    job = panel.analysis_jobs.start(
        body.kind, path, body.session, who, utc_now(), between=body.between
    )
    panel.log(who, f"started the {WORDS[body.kind]} of {body.session}", note=False)
    return job


@router.post("/cancel")
def cancel(request: Request, body: CancelBody, panel: Here) -> Any:
    """Cancel a job at once."""
    who = panel.acting(request)
    job = panel.analysis_jobs.cancel(body.id)
    panel.log(who, f"cancelled the {WORDS[job['kind']]} of {job['session']}", note=False)
    return job


@router.get("/outputs")
def outputs(panel: Here, session: Annotated[str, Query(max_length=400)]) -> Any:
    """Return the files beside a session that an analysis has written, and whether it has been."""
    path = existing(panel.settings.data, session, *SESSION_ENDINGS)
    with open_session(path, live=True) as opened:
        analysed = opened.has_measurements
    return {"outputs": outputs_of(path), "analysed": analysed}


@router.get("/output")
def output(
    panel: Here,
    session: Annotated[str, Query(max_length=400)],
    name: Annotated[str, Query(max_length=40)],
    save: bool = False,
) -> FileResponse:
    """Return one of these files, to be shown, or with `save` to be stored."""
    if name not in ENDINGS:
        raise BadInputError(f"{name!r}: one of {', '.join(ENDINGS)} is possible.")
    path = output_path(existing(panel.settings.data, session, *SESSION_ENDINGS), name)
    if not path.is_file():
        raise MissingError(f"{path.name}: there is no such file yet.")
    return FileResponse(
        path,
        media_type=MEDIA_TYPES[path.suffix],
        filename=path.name,
        content_disposition_type="attachment" if save else "inline",
        headers={"Content-Security-Policy": REPORT_POLICY},
    )
