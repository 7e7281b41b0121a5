"""Notes and photographs of a session: shown, and added during the run or after it."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response
from pydantic import Field

from labrig.errors import BadInputError
from labrig.files import SESSION_ENDINGS
from labrig.panel.core.file_names import existing
from labrig.panel.core.panel import Panel
from labrig.panel.core.requests import Here, Name, RequestModel
from labrig.panel.errors import NotNowError
from labrig.panel.live.frames import jpeg
from labrig.panel.pages.interface import NOWHERE, PanelPage, own_script
from labrig.session import Note, add_note, open_session
from labrig.session.notes.note import NAME_CHARACTERS_MAX, TEXT_CHARACTERS_MAX
from labrig.session.notes.photograph import photograph_note, thumbnail

router = APIRouter(prefix="/api/notes")
_LOGGED_CHARACTERS = 100  # of a note, in the session's log
Who = Annotated[str, Field(max_length=NAME_CHARACTERS_MAX)]
Text = Annotated[str, Field(max_length=TEXT_CHARACTERS_MAX)]


class NoteBody(RequestModel):
    """A note. `session`: by default the one that is run now, or was last.

    `who`: by default the session's operator, and where it states none the holder of control.
    """

    session: Name | None = None
    text: Text = ""
    who: Who = ""


@router.get("")
def listed(panel: Here, session: Annotated[str, Query(max_length=400)] = "") -> Any:
    """Return all notes of a session; its name is null where none is named and none was run yet."""
    if not session and _current(panel) is None:
        return {"session": None, "notes": []}
    path = _path(panel, session or None)
    with open_session(path, live=True) as opened:
        notes = [_shown(note) for note in opened.notes]
    return {"session": path.relative_to(panel.settings.data).as_posix(), "notes": notes}


@router.post("")
def add(request: Request, body: NoteBody, panel: Here) -> Any:
    """Add a text."""
    acting = panel.acting(request)
    path = _path(panel, body.session)
    return _added(panel, acting, path, Note(who=body.who or _author(path, acting), text=body.text))


@router.post("/photograph")
async def add_photograph(
    request: Request,
    panel: Here,
    session: Annotated[str, Query(max_length=400)] = "",
    text: Annotated[str, Query(max_length=TEXT_CHARACTERS_MAX)] = "",
    who: Annotated[str, Query(max_length=NAME_CHARACTERS_MAX)] = "",
    name: Annotated[str, Query(max_length=400)] = "",
) -> Any:
    """Add a photograph: the body is a JPEG or PNG, whatever its stated type."""
    from starlette.concurrency import run_in_threadpool

    acting = panel.acting(request)
    content = await request.body()

    def work() -> Any:
        path = _path(panel, session or None)
        author = who or _author(path, acting)
        note = photograph_note(content, who=author, text=text, file_name=name)
        return _added(panel, acting, path, note)

    return await run_in_threadpool(work)


@router.post("/camera")
def add_frame(request: Request, body: NoteBody, panel: Here) -> Any:
    """Add the newest image of the rig's camera."""
    acting = panel.acting(request)
    newest = panel.frame_pipeline.newest()
    if newest is None:
        raise NotNowError("the camera has not delivered an image yet.")
    header, image = newest
    name = f"camera-frame-{header['frame']}.jpg"
    path = _path(panel, body.session)
    author = body.who or _author(path, acting)
    note = photograph_note(jpeg(image), who=author, text=body.text, file_name=name)
    return _added(panel, acting, path, note)


@router.get("/photograph")
def photograph(
    panel: Here,
    session: Annotated[str, Query(max_length=400)],
    identifier: Annotated[str, Query(max_length=NAME_CHARACTERS_MAX)],
    width: Annotated[int | None, Query(ge=16, le=4000)] = None,
) -> Response:
    """Return a photograph as it was added, or a JPEG of at most that width."""
    with open_session(_path(panel, session), live=True) as opened:
        found = [note for note in opened.notes if note.identifier == identifier]
        content = opened.photograph(identifier)
    if width is not None:
        return Response(thumbnail(content, width), media_type="image/jpeg")
    return Response(content, media_type=found[0].media_type if found else "image/jpeg")


def _author(path: Path, acting: str) -> str:
    """Return who a note is by where nobody is named; a session cut short states nobody."""
    with suppress(BadInputError), open_session(path, live=True) as opened:
        return ", ".join(opened.about.operators)[:NAME_CHARACTERS_MAX] or acting
    return acting


def _added(panel: Panel, acting: str, path: Path, note: Note) -> Any:
    """Add a note, and let all pages know of it."""
    in_file = add_note(path, note)
    name = path.relative_to(panel.settings.data).as_posix()
    what = "added a photograph" if note.has_photograph else "noted"
    told = f"{what}: {_short(note.text)}" if note.text else what
    panel.log(acting, f"{told} ({name})", note=_is_current(panel, path))
    panel.stream.publish_newest({"type": "notes", "session": name})
    return {"ok": True, "in_file": in_file, "note": _shown(note)}


def _shown(note: Note) -> dict[str, Any]:
    return {**note.head, "photograph": note.has_photograph}


def _path(panel: Panel, session: str | None) -> Path:
    if session is not None:
        return existing(panel.settings.data, session, *SESSION_ENDINGS)
    current = _current(panel)
    if current is None:
        raise BadInputError("no session has been run yet; name one.")
    return existing(panel.settings.data, current, *SESSION_ENDINGS)


def _current(panel: Panel) -> str | None:
    """Return the session that is run now, or was last."""
    address = panel.jobs.address
    return None if address is None else address.session


def _is_current(panel: Panel, path: Path) -> bool:
    session = _current(panel)
    return session is not None and panel.settings.data / session == path


def _short(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= _LOGGED_CHARACTERS else f"{line[:_LOGGED_CHARACTERS]}..."


PAGE = PanelPage(
    title="Notes", order=52, modes=NOWHERE, router=router, script=own_script("session_notes")
)
