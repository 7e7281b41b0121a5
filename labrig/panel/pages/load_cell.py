"""The page of the load cell: calibration by dead weights."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Request
from pydantic import Field

from labrig.config import load_load_cell
from labrig.errors import BadInputError, LabrigError
from labrig.experiment.load_cell_calibration import write_calibration
from labrig.panel.core.configuration_files import rig_config
from labrig.panel.core.panel import Panel
from labrig.panel.core.requests import Here, RequestModel
from labrig.panel.errors import NotNowError
from labrig.panel.job.registry import GOING, HIDDEN
from labrig.panel.job.weighing import MADE
from labrig.panel.pages.interface import PanelPage, own_script

router = APIRouter(prefix="/api")
Load = Annotated[float, Field(ge=0.0, le=1e5)]


class WeighingBody(RequestModel):
    """The weights, 0 included, in the order in which they are hung."""

    loads_mN: list[Load] = Field(min_length=3, max_length=50)


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
    _require_weighed(panel)
    made = panel.settings.data / HIDDEN / MADE
    if not made.is_file():
        raise NotNowError("this calibration was accepted already.")
    path = rig_config(panel.rig).load_cell.calibration
    before = set(path.parent.glob("*.toml"))
    write_calibration(load_load_cell(made), path)
    made.unlink()
    kept = sorted(set(path.parent.glob("*.toml")) - before - {path})
    panel.log(who, f"accepted a new {path.name}")
    return {"written": path.name, "kept": kept[0].name if kept else None}


def _require_weighed(panel: Panel) -> None:
    """Raise an error unless the last job was a weighing that ended well."""
    job = panel.jobs.address
    if job is None or job.kind != "weighing" or job.state == GOING:
        raise NotNowError("there is no weighing that has ended.")
    if job.code != 0:
        raise LabrigError(f"the last weighing did not go well: {job.text}")


PAGE = PanelPage(
    title="Load cell",
    order=30,
    modes=frozenset({"rig"}),
    router=router,
    script=own_script("load_cell"),
)
