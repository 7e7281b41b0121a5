"""What the routes of all pages share: the panel, bodies, names."""

from __future__ import annotations

from typing import Annotated

from fastapi import Depends
from pydantic import BaseModel, ConfigDict, Field
from starlette.requests import HTTPConnection

from labrig.panel.core.panel import Panel


async def panel_of(connection: HTTPConnection) -> Panel:
    """Return the panel that a request or socket is for.

    Async, so that it needs no thread: STOP is answered where all threads are busy.
    """
    panel: Panel = connection.app.state.panel
    return panel


Here = Annotated[Panel, Depends(panel_of)]
Name = Annotated[str, Field(min_length=1, max_length=400)]


class RequestModel(BaseModel):
    """The body of a request; an unknown field is an error."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)
