"""The page of a new run: configuration files and their forms, the plan, preflight, start."""

from __future__ import annotations

from pathlib import PurePosixPath
from typing import Any, Literal

from fastapi import APIRouter, Request
from pydantic import Field

from labrig.config import read_text
from labrig.config.schema import schemas
from labrig.errors import BadInputError, LabrigError
from labrig.experiment.plan import Plan, load_plan, make_plan
from labrig.experiment.rig.networked_rig import why_not_served
from labrig.files import SESSION_ENDINGS
from labrig.panel.analysis.outputs import ENDINGS
from labrig.panel.core import configuration_files as files
from labrig.panel.core.configuration_files import about_text
from labrig.panel.core.file_names import existing, inside
from labrig.panel.core.panel import Panel
from labrig.panel.core.requests import Here, Name, RequestModel
from labrig.panel.live.plans import message_of_plan
from labrig.panel.pages._sessions import Session
from labrig.panel.pages.interface import PanelPage, own_script

router = APIRouter(prefix="/api")
_SUFFIXES = (".toml", ".json")


class FileBody(RequestModel):
    """A file as text, or as the values of a form."""

    kind: Literal["rig", "sheet", "protocol", "load_cell", "about", "optics", "model", "world"]
    text: str | None = Field(None, max_length=200_000)
    values: dict[str, Any] | None = None

    def file(self, name: str, before: str = "") -> files.ConfigFile:
        """As text, with its faults."""
        if (self.text is None) == (self.values is None):
            raise BadInputError("give either text or values.")
        if self.text is not None:
            return files.from_text(self.kind, self.text, name)
        return files.from_values(self.kind, self.values or {}, name, before)


class PlanBody(RequestModel):
    """Which files make the plan; `protocol_text`: one that is not in a file yet."""

    protocol: Name | None = None
    protocol_text: str | None = Field(None, max_length=200_000)
    sheet: Name = "sheet.toml"


@router.get("/schemas")
def all_schemas() -> Any:
    """JSON Schemas, for forms."""
    return schemas()


@router.get("/files")
def list_all(panel: Here) -> Any:
    """Return the files of the rig's folder."""
    return {"files": files.list_files(panel.rig.parent)}


@router.get("/files/{name}")
def read(name: str, panel: Here) -> Any:
    """One file."""
    path = existing(panel.rig.parent, name, *_SUFFIXES)
    return {"name": name, **files.read_file(path).as_dict()}


@router.get("/next-protocol")
def next_protocol(panel: Here, session: Session) -> Any:
    """Return the protocol that was proposed after a session; it lies beside it."""
    name = PurePosixPath(session).with_suffix(ENDINGS["next"]).as_posix()
    existing(panel.settings.data, session, *SESSION_ENDINGS)
    path = existing(panel.settings.data, name, ".toml")
    return {"name": path.name, **files.read_file(path).as_dict()}


@router.post("/files/check")
def check(body: FileBody) -> Any:
    """Is it right? Nothing is written."""
    return body.file(f"{body.kind}.toml").as_dict()


@router.put("/files/{name}")
def write(request: Request, name: str, body: FileBody, panel: Here) -> Any:
    """Write a file, when there is no fault in it."""
    who = panel.acting(request)
    path = inside(panel.rig.parent, name, ".toml")
    if body.kind not in files.WRITABLE or path.resolve() == panel.rig.resolve():
        raise BadInputError(f"{name}: only protocols and sheets are written here.")
    before = read_text(path) if path.exists() else ""
    if before and files.kind_of(before, path.suffix) not in (body.kind, ""):
        raise BadInputError(f"{name}: is a file of another kind; choose another name.")
    found = body.file(name, before)
    if found.errors:
        raise BadInputError(" ".join(found.errors))
    part = path.with_name(path.name + ".part")
    try:
        part.write_text(found.text, encoding="utf-8")
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise LabrigError(f"{name}: cannot be written ({error.strerror}).") from None
    panel.log(who, f"wrote {name}")
    return {"name": name, **found.as_dict()}


@router.get("/about")
def about(panel: Here) -> Any:
    """Return what the about.toml beside rig.toml states."""
    return files.about_file(panel.rig.parent).as_dict()


@router.post("/plan")
def plan(body: PlanBody, panel: Here) -> Any:
    """Return what would be done, and on which clocks a simulated rig can do it."""
    found = _planned(body, panel)
    clock = "virtual" if panel.simulated else "real"
    why_not = why_not_served(found.schedule) if panel.simulated else ""
    return {**message_of_plan(found, clock, None), "not_on_real_clock": why_not or None}


def _planned(body: PlanBody, panel: Panel) -> Plan:
    folder = panel.rig.parent
    sheet = existing(folder, body.sheet, ".toml")
    if body.protocol_text is None:
        protocol = existing(folder, body.protocol or "protocol.toml", ".toml")
        return load_plan(panel.rig, protocol, sheet)
    return _plan_of_text(panel, body.protocol_text, body.sheet)


def _plan_of_text(panel: Panel, text: str, sheet: str) -> Plan:
    config = files.rig_config(panel.rig)
    texts = {
        "rig.toml": read_text(panel.rig),
        "sheet.toml": read_text(existing(panel.rig.parent, sheet, ".toml")),
        "protocol.toml": text,
        "load_cell.toml": read_text(config.load_cell.calibration),
    }
    if config.camera is not None:
        texts["optics.json"] = read_text(config.camera.optics)
    return make_plan(config, texts)


class RunBody(RequestModel):
    """A new session, or one to continue."""

    protocol: Name = "protocol.toml"
    sheet: Name = "sheet.toml"
    session: Name | None = None
    clock: Literal["real", "virtual"] = "virtual"
    about: dict[str, Any] | None = None  # in place of about.toml, for this session alone
    resume: Name | None = None


class PreflightBody(RequestModel):
    """For which protocol and sheet the rig is to be ready."""

    protocol: Name = "protocol.toml"
    sheet: Name = "sheet.toml"


@router.post("/run")
def run(request: Request, body: RunBody, panel: Here) -> Any:
    """Start a run."""
    who = panel.acting(request)
    data, folder = panel.settings.data, panel.rig.parent
    if body.resume is not None:
        before = existing(data, body.resume, *SESSION_ENDINGS)
        name = body.session or str(PurePosixPath(body.resume).with_suffix("")) + "-resumed.h5"
        files: dict[str, str] = {"resume": str(before)}
    elif body.session is None:
        raise BadInputError("a run needs the name of the session file to make.")
    else:
        name = body.session
        files = {
            "protocol": str(existing(folder, body.protocol, ".toml")),
            "sheet": str(existing(folder, body.sheet, ".toml")),
        }
        if body.about is not None:
            files["about"] = about_text(folder, body.about)
    session = inside(data, name, *SESSION_ENDINGS)
    if session.exists():
        raise BadInputError(f"{name} exists already; choose another name.")
    session.parent.mkdir(parents=True, exist_ok=True)
    order = panel.order("run", who, session=str(session), clock=body.clock, **files)
    job = panel.jobs.start(order)
    panel.log(who, f"started the run {name}", note=False)
    return job


@router.post("/preflight")
def preflight(request: Request, body: PreflightBody, panel: Here) -> Any:
    """Check whether the rig is ready."""
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


PAGE = PanelPage(
    title="New run", order=20, modes=frozenset({"rig"}), router=router, script=own_script("new")
)
