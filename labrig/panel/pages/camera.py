"""The page of the camera: live images, calibration, and the arc."""

from __future__ import annotations

from typing import Any, Literal

from fastapi import APIRouter, Request, Response
from pydantic import Field

from drivers.interfaces import GreyImage
from labrig.errors import BadInputError
from labrig.panel.calibration import point_refinement as refining
from labrig.panel.calibration.camera_calibration import CameraCalibrationRun, arc_through
from labrig.panel.core.configuration_files import rig_config
from labrig.panel.core.panel import Panel
from labrig.panel.core.requests import Here, RequestModel
from labrig.panel.errors import NotNowError
from labrig.panel.live.frames import png
from labrig.panel.pages.interface import PanelPage, own_script
from labrig.vision import CalibrationBoard, load_optics

router = APIRouter(prefix="/api")
Pixel = tuple[float, float]


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
    return panel.state(CameraCalibrationRun).add_view(_newest(panel), body.board.board())


@router.get("/camera/view/{number}")
def get_view(number: int, panel: Here) -> Response:
    """Return a kept view."""
    return Response(
        png(panel.state(CameraCalibrationRun).view(number).image), media_type="image/png"
    )


@router.delete("/camera/view/{number}")
def remove_view(request: Request, number: int, panel: Here) -> Any:
    """Forget a view."""
    panel.acting(request)
    panel.state(CameraCalibrationRun).remove(number)
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
    making = panel.state(CameraCalibrationRun)
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
    made = panel.state(CameraCalibrationRun).made
    if made is not None:
        return arc_through(made.optics, body.px)
    config = rig_config(panel.rig)
    if config.camera is None:
        raise BadInputError(f"{panel.rig.name}: names no camera; add [camera].")
    return arc_through(load_optics(config.camera.optics), body.px)


@router.post("/camera/accept")
def accept_camera(request: Request, panel: Here) -> Any:
    """Put the new optics.json in the place of the old one, which is kept."""
    who = panel.acting(request)
    config = rig_config(panel.rig)
    if config.camera is None:
        raise BadInputError(f"{panel.rig.name}: names no camera; add [camera].")
    kept, carried = panel.state(CameraCalibrationRun).accept(config.camera.optics)
    panel.log(who, f"accepted a new {config.camera.optics.name}")
    return {"written": config.camera.optics.name, "kept": kept, "carried": carried}


def _newest(panel: Panel) -> GreyImage:
    newest = panel.frame_pipeline.newest()
    if newest is None:
        raise NotNowError("there is no picture yet; start the camera first.")
    return newest[1]


PAGE = PanelPage(
    title="Camera", order=40, modes=frozenset({"rig"}), router=router, script=own_script("camera")
)
