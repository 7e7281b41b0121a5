"""What every page needs: the status, control, and STOP."""

from __future__ import annotations

import json
from functools import cache
from typing import Annotated, Any, Literal

from anyio import CapacityLimiter, to_thread
from fastapi import APIRouter, Depends, Request
from pydantic import Field

from labrig.panel.core.panel import Panel
from labrig.panel.core.requests import Here, RequestModel
from labrig.panel.core.sockets import address_of
from labrig.panel.job.registry import GOING
from labrig.panel.live.event_stream import Message
from labrig.panel.pages.interface import listing
from labrig.panel.stop.press import NO_RUN

router = APIRouter(prefix="/api")
_MOST_PRESSES = 16  # of STOP, at a time


class ControlBody(RequestModel):
    """Take control or give it back."""

    do: Literal["take", "release"]
    name: str = Field("", max_length=80)
    force: bool = False


class StopBody(RequestModel):
    """STOP."""

    why: str = Field("", max_length=200)
    name: str = Field("", max_length=80)


def full_status(panel: Panel, host: str, client: str) -> Message:
    """Return the panel's status with the pages that it has."""
    return {**panel.status(host, client), **listing(panel.settings.mode)}


@router.get("/status")
def status(request: Request, panel: Here) -> Any:
    """Return what is going on."""
    client = request.headers.get("x-labrig-client", "")
    return full_status(panel, request.headers.get("host", ""), client)


async def stop_body(request: Request) -> StopBody:
    """Accept any body of a press: JSON, a form without a script, or none."""
    try:
        found = json.loads(await request.body())
    except (ValueError, RecursionError):
        found = {}
    found = found if isinstance(found, dict) else {}
    return StopBody(why=str(found.get("why") or "")[:200], name=str(found.get("name") or "")[:80])


@router.post("/stop")
async def stop(request: Request, body: Annotated[StopBody, Depends(stop_body)], panel: Here) -> Any:
    """Stop the job by the second path, straight to it. No control is needed."""
    # In threads of its own: those of the other requests may all be busy.
    return await to_thread.run_sync(_press, request, body, panel, limiter=_presses())


def _press(request: Request, body: StopBody, panel: Panel) -> Message:
    client = request.headers.get("x-labrig-client", "")
    who = panel.control.who(client, address_of(request))
    job = panel.jobs.address
    panel.actions.add(who, f"pressed STOP{': ' + body.why if body.why else ''}")
    if job is None or job.state != GOING:
        return {"sent": False, "told": NO_RUN}
    panel.jobs.ask({"do": "stop", "who": who, "why": body.why})
    return {"sent": True, "told": "the run was asked to stop"}


@cache
def _presses() -> CapacityLimiter:
    return CapacityLimiter(_MOST_PRESSES)


@router.post("/control")
def control(request: Request, body: ControlBody, panel: Here) -> Any:
    """Take control, or release it."""
    client = request.headers.get("x-labrig-client", "")
    if body.do == "take":
        holder = panel.control.take(client, body.name, force=body.force)
        panel.log(holder.name, "took control")
    else:
        who = panel.control.require(client)
        panel.control.release(client)
        panel.log(who, "gave control back")
    return panel.control.message_for(client)
