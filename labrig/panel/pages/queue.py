"""The page of the queue: sessions that begin by themselves, in an order that can be changed."""

from __future__ import annotations

from typing import Any, Literal

from fastapi import APIRouter, Request
from pydantic import Field

from labrig.errors import BadInputError
from labrig.experiment.plan import load_plan
from labrig.experiment.rig.networked_rig import why_not_served
from labrig.files import SESSION_ENDINGS
from labrig.panel.core.configuration_files import about_text
from labrig.panel.core.file_names import existing, inside
from labrig.panel.core.panel import Panel
from labrig.panel.core.requests import Here, Name, RequestModel
from labrig.panel.pages.interface import PanelPage, own_script
from labrig.panel.queue.entries import Entry

router = APIRouter(prefix="/api/queue")


class AddBody(RequestModel):
    """A session at the end of the queue; without `session` it gets a name."""

    protocol: Name = "protocol.toml"
    sheet: Name = "sheet.toml"
    session: Name | None = None
    clock: Literal["real", "virtual"] = "virtual"
    about: dict[str, Any] | None = None  # in place of about.toml, for this session alone


class MoveBody(RequestModel):
    """An entry, so many places up (negative) or down."""

    id: Name
    by: int = Field(ge=-100, le=100)


class EntryBody(RequestModel):
    """An entry."""

    id: Name


@router.get("")
def queue(panel: Here) -> Any:
    """Return the queue."""
    return panel.queue.queue.message()


@router.post("/add")
def add(request: Request, body: AddBody, panel: Here) -> Any:
    """Add a session."""
    who, folder = panel.acting(request), panel.rig.parent
    protocol = existing(folder, body.protocol, ".toml")
    sheet = existing(folder, body.sheet, ".toml")
    if panel.simulated and body.clock == "real":
        why_not = why_not_served(load_plan(panel.rig, protocol, sheet).schedule)
        if why_not:
            raise BadInputError(why_not)
    if body.session is not None:
        inside(panel.settings.data, body.session, *SESSION_ENDINGS)
    entry = panel.queue.add(
        Entry(
            id="",
            protocol=body.protocol,
            sheet=body.sheet,
            session=body.session or "",
            clock=body.clock,
            about=None if body.about is None else about_text(folder, body.about),
        )
    )
    return _done(panel, who, f"added {entry.session} to the queue")


@router.post("/remove")
def remove(request: Request, body: EntryBody, panel: Here) -> Any:
    """Remove a session that does not run."""
    who = panel.acting(request)
    panel.queue.remove(body.id)
    return _done(panel, who, "removed a session from the queue")


@router.post("/move")
def move(request: Request, body: MoveBody, panel: Here) -> Any:
    """Change the order of those that wait."""
    who = panel.acting(request)
    panel.queue.move(body.id, body.by)
    return _done(panel, who, "changed the order of the queue")


@router.post("/start")
def start(request: Request, panel: Here) -> Any:
    """Check all that wait, then begin with the first."""
    who = panel.acting(request)
    panel.queue.start(who)
    return _done(panel, who, "started the queue")


@router.post("/hold")
def hold(request: Request, panel: Here) -> Any:
    """Begin no further session; the one that runs goes on."""
    who = panel.acting(request)
    panel.queue.hold(f"Held by {who}.")
    return _done(panel, who, "held the queue")


def _done(panel: Panel, who: str, what: str) -> Any:
    panel.log(who, what, note=False)
    return panel.queue.queue.message()


PAGE = PanelPage(
    title="Queue", order=22, modes=frozenset({"rig"}), router=router, script=own_script("queue")
)
