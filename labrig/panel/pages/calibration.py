"""Calibration of load cell and camera, step by step."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import APIRouter, Request, Response
from pydantic import Field

from drivers.interfaces import GreyImage
from labrig.config import RigConfig, load_load_cell, load_rig
from labrig.errors import BadInputError
from labrig.experiment.load_cell_calibration import write_calibration
from labrig.panel.job.registry import HIDDEN
from labrig.panel.job.weighing import MADE
from labrig.panel.live.frames import png
from labrig.panel.pages import point_refinement as refining
from labrig.panel.pages.camera_calibration import arc_through
from labrig.panel.pages.run import Here, RequestModel, ended_or_refuse
from labrig.panel.server.errors import NotNowError
from labrig.panel.server.panel import Panel
from labrig.vision import CalibrationBoard, load_optics

router = APIRouter(prefix="/api")
Pixel = tuple[float, float]
Load = Annotated[float, Field(ge=0.0, le=1e5)]


class WeighingBody(RequestModel):
    """The weights, 0 included, in the order in which they are hung."""

    loads_mN: list[Load] = Field(min_length=3, max_length=50)


class CameraBody(RequestModel):
    """Live pictures on or off."""

    do: Literal["start", "end"]


class BoardBody(RequestModel):
    """The printed board."""

    columns: int = 12
    rows: int = 9
    square_mm: float = 5.0
    marker_mm: float = 3.6

    def board(self) -> CalibrationBoard:
        """As `labrig.vision` takes it."""
        return CalibrationBoard(**self.model_dump())


class ViewBody(RequestModel):
    """Keep the newest picture."""

    board: BoardBody = BoardBody()


class RefineBody(RequestModel):
    """A click."""

    what: Literal["corner", "round"]
    px: Pixel
    reach_px: float = Field(12.0, ge=3.0, le=60.0)


class CalibrateBody(RequestModel):
    """From views of the board, or from a scale bar."""

    clamp_px: Pixel
    board: BoardBody = BoardBody()
    views: list[int] = Field([], max_length=30)
    along_px: Pixel | None = None
    ruler_px: tuple[Pixel, Pixel] | None = None
    ruler_mm: float | None = Field(None, gt=0, le=10_000)


class ArcBody(RequestModel):
    """The roll at position 0."""

    px: Pixel


@router.post("/weighing")
def weighing(request: Request, body: WeighingBody, panel: Here) -> Any:
    """Begin to weigh."""
    who = panel.acting(request)
    if len(set(body.loads_mN)) < 2:
        raise BadInputError("two different weights at least are needed, 0 included.")
    job = panel.jobs.start(panel.order("weighing", who, loads_mN=tuple(body.loads_mN)))
    panel.log(who, "began to weigh the load cell", note=False)
    return job


@router.post("/weighing/accept")
def accept_weighing(request: Request, panel: Here) -> Any:
    """Put the new calibration in the place of the old one, which is kept."""
    who = panel.acting(request)
    ended_or_refuse(panel, "weighing")
    made = panel.settings.data / HIDDEN / MADE
    if not made.is_file():
        raise NotNowError("this calibration was accepted already.")
    path = _rig_of(panel).load_cell.calibration
    before = set(path.parent.glob("*.toml"))
    write_calibration(load_load_cell(made), path)
    made.unlink()
    kept = sorted(set(path.parent.glob("*.toml")) - before - {path})
    panel.log(who, f"accepted a new {path.name}")
    return {"written": path.name, "kept": kept[0].name if kept else None}


@router.post("/camera")
def camera(request: Request, body: CameraBody, panel: Here) -> Any:
    """Live pictures without a run."""
    who = panel.acting(request)
    if body.do == "start":
        return panel.jobs.start(panel.order("camera", who))
    panel.jobs.ask({"do": "end", "who": who})
    return panel.jobs.message()


@router.post("/camera/view")
def add_view(request: Request, body: ViewBody, panel: Here) -> Any:
    """Keep the newest picture as a view of the board."""
    panel.acting(request)
    return panel.calibrating.add_view(_newest(panel), body.board.board())


@router.get("/camera/view/{number}")
def get_view(number: int, panel: Here) -> Response:
    """A kept view."""
    return Response(png(panel.calibrating.view(number).image), media_type="image/png")


@router.delete("/camera/view/{number}")
def remove_view(request: Request, number: int, panel: Here) -> Any:
    """Forget a view."""
    panel.acting(request)
    panel.calibrating.remove(number)
    return {"ok": True}


@router.post("/camera/refine")
def refine(request: Request, body: RefineBody, panel: Here) -> Any:
    """From a click to a fraction of a pixel."""
    panel.acting(request)
    found = refining.refine(_newest(panel), body.px, body.what, body.reach_px)
    return {"px": found.px, "sigma_px": found.sigma_px, "moved_px": found.moved_px}


@router.post("/camera/calibrate")
def calibrate(request: Request, body: CalibrateBody, panel: Here) -> Any:
    """Scale, axes and lens. Nothing is written yet."""
    panel.acting(request)
    making = panel.calibrating
    if body.ruler_px is not None:
        if body.ruler_mm is None:
            raise BadInputError("ruler_mm is missing: how far are the two points apart?")
        return making.from_ruler(_newest(panel), body.ruler_px, body.ruler_mm, body.clamp_px)
    if not body.views:
        raise BadInputError("views of the board, or the ends of a scale bar, are needed.")
    return making.from_board(body.board.board(), body.views, body.clamp_px, body.along_px)


@router.post("/camera/arc")
def arc(request: Request, body: ArcBody, panel: Here) -> Any:
    """Where the arc is, from a roll at position 0."""
    panel.acting(request)
    made = panel.calibrating.made
    if made is not None:
        return arc_through(made.optics, body.px)
    config = _rig_of(panel)
    if config.camera is None:
        raise BadInputError(f"{panel.rig.name}: names no camera; add [camera].")
    return arc_through(load_optics(config.camera.optics), body.px)


@router.post("/camera/accept")
def accept_camera(request: Request, panel: Here) -> Any:
    """Put the new optics.json in the place of the old one, which is kept."""
    who = panel.acting(request)
    config = _rig_of(panel)
    if config.camera is None:
        raise BadInputError(f"{panel.rig.name}: names no camera; add [camera].")
    kept = panel.calibrating.accept(config.camera.optics)
    panel.log(who, f"accepted a new {config.camera.optics.name}")
    return {"written": config.camera.optics.name, "kept": kept}


def _newest(panel: Panel) -> GreyImage:
    newest = panel.darkroom.newest()
    if newest is None:
        raise NotNowError("there is no picture yet; start the camera first.")
    return newest[1]


def _rig_of(panel: Panel) -> RigConfig:
    config = load_rig(panel.rig)
    if not isinstance(config, RigConfig):
        raise BadInputError(f"{panel.rig.name}: this rig is a recorded session.")
    return config
