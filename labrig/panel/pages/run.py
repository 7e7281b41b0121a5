"""The page of the present run: prompts, marks, the gentle stop, the model drawn."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request
from pydantic import Field

from labrig.panel.core.file_names import existing, inside
from labrig.panel.core.requests import Here, Name, RequestModel
from labrig.panel.pages.interface import PanelPage, own_script

router = APIRouter(prefix="/api")


class AnswerBody(RequestModel):
    """An answer to a prompt."""

    prompt: int
    done: bool


class MarkBody(RequestModel):
    """A reading, or a whole run, that is invalid."""

    run: int = Field(ge=0)
    reading: int | None = Field(None, ge=0)
    why: str = Field(min_length=1, max_length=200)


class PauseBody(RequestModel):
    """A pause after this position, or its end."""

    on: bool


class ModelBody(RequestModel):
    """Whose predicted curve is drawn."""

    name: Name | None


@router.post("/answer")
def answer(request: Request, body: AnswerBody, panel: Here) -> Any:
    """Answer what the run asks."""
    who = panel.acting(request)
    panel.jobs.ask({"do": "answer", "prompt": body.prompt, "done": body.done, "who": who})
    panel.actions.add(who, f"answered {'yes' if body.done else 'no'}")
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
    """Return the gentle stop."""
    who = panel.acting(request)
    panel.jobs.ask({"do": "stop_after_pulse", "who": who})
    panel.actions.add(who, "asked for a stop after the pulse")
    return {"ok": True}


@router.post("/pause")
def pause(request: Request, body: PauseBody, panel: Here) -> Any:
    """Pause after this position, at 0 V, or continue."""
    who = panel.acting(request)
    panel.jobs.ask({"do": "pause", "on": body.on, "who": who})
    panel.actions.add(who, "asked for a pause" if body.on else "ended the pause")
    return {"ok": True}


@router.post("/model")
def model(request: Request, body: ModelBody, panel: Here) -> Any:
    """Choose whose predicted curve is drawn."""
    who = panel.acting(request)
    path = None
    if body.name is not None:
        from labrig.model_file import load_model

        with_rig = panel.settings.rig is not None and inside(panel.rig.parent, body.name).is_file()
        folder = panel.rig.parent if with_rig else panel.settings.data
        path = existing(folder, body.name, ".toml")
        load_model(path)  # a file that is no model is refused here, with its sentence
    panel.choose_model(path)
    panel.log(who, f"chose the model {body.name}" if body.name else "chose no model")
    return {"name": body.name}


PAGE = PanelPage(
    title="Run",
    order=10,
    modes=frozenset({"rig"}),
    opens=frozenset({"rig"}),
    router=router,
    script=own_script("run"),
)
