"""What is going on, and what may be done about it."""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Depends, Request
from pydantic import BaseModel, ConfigDict, Field

from labrig.errors import BadInputError, LabrigError
from labrig.panel.job.registry import GOING
from labrig.panel.pages.file_names import existing, inside
from labrig.panel.pages.sockets import address_of
from labrig.panel.server.errors import NotNowError
from labrig.panel.server.panel import Panel

router = APIRouter(prefix="/api")


def panel_of(request: Request) -> Panel:
    """The panel that a request is for."""
    panel: Panel = request.app.state.panel
    return panel


Here = Annotated[Panel, Depends(panel_of)]
Name = Annotated[str, Field(min_length=1, max_length=400)]


class RequestModel(BaseModel):
    """What a page sends: what is not known is a mistake."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class ControlBody(RequestModel):
    """Take control or give it back."""

    do: Literal["take", "release"]
    name: str = Field("", max_length=80)
    force: bool = False


class StopBody(RequestModel):
    """STOP."""

    why: str = Field("", max_length=200)
    name: str = Field("", max_length=80)


class RunBody(RequestModel):
    """A new session, or one to go on with."""

    protocol: Name = "protocol.toml"
    sheet: Name = "sheet.toml"
    session: Name | None = None
    clock: Literal["real", "virtual"] = "virtual"
    resume: Name | None = None


class PreflightBody(RequestModel):
    """For which protocol and sheet the rig is to be ready."""

    protocol: Name = "protocol.toml"
    sheet: Name = "sheet.toml"


class AnswerBody(RequestModel):
    """An answer to a prompt."""

    prompt: int
    done: bool


class MarkBody(RequestModel):
    """A reading, or a whole run, that is invalid."""

    run: int = Field(ge=0)
    reading: int | None = Field(None, ge=0)
    why: str = Field(min_length=1, max_length=200)


class ModelBody(RequestModel):
    """Whose predicted curve is drawn."""

    name: Name | None


@router.get("/status")
def status(request: Request, panel: Here) -> Any:
    """What is going on."""
    client = request.headers.get("x-labrig-client", "")
    return panel.status(request.headers.get("host", ""), client)


@router.get("/log")
def log(panel: Here, limit: int = 200) -> Any:
    """What was done at panels."""
    return {"actions": panel.actions.last(max(1, min(limit, 2000)))}


async def whatever_was_said(request: Request) -> StopBody:
    """A press counts, however it is written: as JSON, as a form without a script, or empty."""
    try:
        said = json.loads(await request.body())
    except (ValueError, RecursionError):
        said = {}
    said = said if isinstance(said, dict) else {}
    return StopBody(why=str(said.get("why") or "")[:200], name=str(said.get("name") or "")[:80])


@router.post("/stop")
def stop(
    request: Request, body: Annotated[StopBody, Depends(whatever_was_said)], panel: Here
) -> Any:
    """The second way to STOP: straight to the job. No control is needed."""
    client = request.headers.get("x-labrig-client", "")
    who = panel.control.who(client, address_of(request))
    place = panel.jobs.place
    if place is None or place.state != GOING:
        return {"sent": False, "told": "no run is going on"}
    panel.jobs.ask({"do": "stop", "who": who, "why": body.why})
    panel.actions.add(who, f"pressed STOP{': ' + body.why if body.why else ''}")
    return {"sent": True, "told": "the run was asked to stop"}


@router.post("/control")
def control(request: Request, body: ControlBody, panel: Here) -> Any:
    """Take control, or give it back."""
    client = request.headers.get("x-labrig-client", "")
    if body.do == "take":
        holder = panel.control.take(client, body.name, force=body.force)
        panel.log(holder.name, "took control")
    else:
        who = panel.control.require(client)
        panel.control.release(client)
        panel.log(who, "gave control back")
    return panel.control.message_for(client)


@router.post("/run")
def run(request: Request, body: RunBody, panel: Here) -> Any:
    """Start a run."""
    who = panel.acting(request)
    data, folder = panel.settings.data, panel.rig.parent
    if body.resume is not None:
        before = existing(data, body.resume, ".h5")
        name = body.session or body.resume.removesuffix(".h5") + "-resumed.h5"
        files: dict[str, str] = {"resume": str(before)}
    elif body.session is None:
        raise BadInputError("a run needs the name of the session file to make.")
    else:
        name = body.session
        files = {
            "protocol": str(existing(folder, body.protocol, ".toml")),
            "sheet": str(existing(folder, body.sheet, ".toml")),
        }
    session = inside(data, name, ".h5")
    if session.exists():
        raise BadInputError(f"{name} exists already; choose another name.")
    session.parent.mkdir(parents=True, exist_ok=True)
    order = panel.order("run", who, session=str(session), clock=body.clock, **files)
    job = panel.jobs.start(order)
    panel.log(who, f"started the run {name}", note=False)
    return job


@router.post("/preflight")
def preflight(request: Request, body: PreflightBody, panel: Here) -> Any:
    """Look whether the rig is ready."""
    who, folder = panel.acting(request), panel.rig.parent
    order = panel.order(
        "preflight",
        who,
        protocol=str(existing(folder, body.protocol, ".toml")),
        sheet=str(existing(folder, body.sheet, ".toml")),
    )
    job = panel.jobs.start(order)
    panel.log(who, "asked for a preflight", note=False)
    return job


@router.post("/answer")
def answer(request: Request, body: AnswerBody, panel: Here) -> Any:
    """Answer what the run asks."""
    who = panel.acting(request)
    panel.jobs.ask({"do": "answer", "prompt": body.prompt, "done": body.done, "who": who})
    panel.actions.add(who, f"answered {'done' if body.done else 'stop'}")
    return {"ok": True}


@router.post("/mark")
def mark(request: Request, body: MarkBody, panel: Here) -> Any:
    """Declare a reading invalid."""
    who = panel.acting(request)
    what = {"run": body.run, "reading": body.reading, "why": body.why}
    panel.jobs.ask({"do": "mark", "who": who, **what})
    which = "all of" if body.reading is None else f"reading {body.reading + 1} of"
    panel.actions.add(who, f"marked {which} run {body.run + 1} invalid: {body.why}")
    return {"ok": True}


@router.post("/stop_after_pulse")
def stop_after_pulse(request: Request, panel: Here) -> Any:
    """The gentle stop."""
    who = panel.acting(request)
    panel.jobs.ask({"do": "stop_after_pulse", "who": who})
    panel.actions.add(who, "asked for a stop after the pulse")
    return {"ok": True}


@router.post("/model")
def model(request: Request, body: ModelBody, panel: Here) -> Any:
    """Choose whose predicted curve is drawn."""
    who = panel.acting(request)
    path = None
    if body.name is not None:
        from labrig.model_file import load_model

        beside = panel.settings.rig is not None and inside(panel.rig.parent, body.name).is_file()
        folder = panel.rig.parent if beside else panel.settings.data
        path = existing(folder, body.name, ".toml")
        load_model(path)  # a file that is no model is refused here, with its sentence
    panel.choose_model(path)
    panel.log(who, f"chose the model {body.name}" if body.name else "chose no model")
    return {"name": body.name}


def ended_or_refuse(panel: Panel, kind: str) -> None:
    """For what is only there when the last job was of a kind, and went well."""
    place = panel.jobs.place
    if place is None or place.kind != kind or place.state == GOING:
        raise NotNowError(f"there is no {kind} that has ended.")
    if place.code != 0:
        raise LabrigError(f"the last {kind} did not go well: {place.text}")
