"""Read the files of an experiment and make its schedule."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from drivers.load_cell import LoadCellCalibration
from labrig.config import (
    About,
    ProtocolConfig,
    ReplayConfig,
    RigConfig,
    file_kinds,
    load_rig,
    parse_about,
    parse_load_cell,
    parse_protocol,
    parse_sheet,
    read_text,
)
from labrig.config.about import FILE as ABOUT
from labrig.config.file_kinds import LOAD_CELL, OPTICS, PROTOCOL, RIG, SHEET, TEXT
from labrig.config.load_cell import FORCE_UNIT
from labrig.control.controller_file import (
    ControllerConfig,
    load_controller,
    parse_controller,
    require_fit,
)
from labrig.control.reference import CONTROLLER, REFERENCE, controlled_schedule
from labrig.errors import BadInputError
from labrig.files import typed
from labrig.serialise import to_plain
from labrig.session.tables.drive_table import read_protocol
from labrig.vision import Optics
from model.measurements import SheetGeometry
from protocols import SafetyLimits, Schedule, ScheduleError, check_schedule

_KINDS = {
    "rig.toml": RIG, "sheet.toml": SHEET, "protocol.toml": PROTOCOL, "load_cell.toml": LOAD_CELL,
    "optics.json": OPTICS, ABOUT: file_kinds.ABOUT, CONTROLLER: file_kinds.CONTROLLER,
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Plan:
    """Everything that is known before a rig is touched."""

    rig: RigConfig
    protocol: ProtocolConfig
    sheets: dict[str, SheetGeometry]
    calibration: LoadCellCalibration
    optics: Optics | None
    schedule: Schedule
    about: About  # title, people and sample; empty where nothing states them
    texts: Mapping[str, str]  # the files as written, by the names they have in a session
    # sessions that this one adds to: a simulated rig has other noise and set-ups in each of them
    earlier: int = 0
    controller: ControllerConfig | None = None  # sets the voltage in place of the protocol

    @property
    def arc_radius_m(self) -> float:
        """Of the arc on which the stage moves; it is one for all configurations."""
        return next(iter(self.sheets.values())).arc_radius_m

    def resolved(self) -> dict[str, Any]:
        """Return the files as understood, as plain JSON."""
        return {
            "rig": self.rig.model_dump(mode="json"),
            "protocol": self.protocol.model_dump(mode="json"),
            "sheet": {name: to_plain(sheet) for name, sheet in self.sheets.items()},
            "load_cell": to_plain(self.calibration),
            FORCE_UNIT: self.rig.raw_force_unit,
            "optics": None if self.optics is None else self.optics.model_dump(mode="json"),
            **({} if self.about.is_empty else {"about": self.about.model_dump(mode="json")}),
        }

    def with_about(self, text: str, name: str = ABOUT) -> Plan:
        """Return the plan with another about.toml; BadInputError for any fault in it."""
        return replace(self, about=parse_about(text, name), texts={**self.texts, ABOUT: text})


@dataclass(frozen=True)
class ControlFiles:
    """What a controlled run needs on top: controller.toml, and the reference of the force."""

    controller: Path
    reference: Path


def load_plan(
    rig: Path,
    protocol: Path,
    sheet: Path,
    about: Path | None = None,
    control: ControlFiles | None = None,
) -> Plan:
    """Read the three files and the calibrations they name; BadInputError for any fault in them.

    `about` is by default the about.toml beside rig.toml, where there is one.
    """
    config = load_rig(rig)
    if isinstance(config, ReplayConfig):
        raise BadInputError(
            f"{rig}: this rig is a recorded session; run it with "
            f"`labrig replay {typed(config.replay)}`."
        )
    paths = {"rig.toml": rig, "sheet.toml": sheet, "protocol.toml": protocol}
    paths["load_cell.toml"] = config.load_cell.calibration
    if config.camera is not None:
        paths["optics.json"] = config.camera.optics
    if about is not None or (rig.parent / ABOUT).exists():
        paths[ABOUT] = about or rig.parent / ABOUT
    if control is not None:
        paths |= {CONTROLLER: control.controller, REFERENCE: control.reference}
        load_controller(control.controller)  # its model file may have changed
    texts = {name: read_text(path, _KINDS.get(name, TEXT)) for name, path in paths.items()}
    texts["protocol.toml"] = read_protocol(protocol)
    names = {name: str(path) for name, path in paths.items()}
    return make_plan(config, texts, names)


def make_plan(
    rig: RigConfig, texts: Mapping[str, str], names: Mapping[str, str] | None = None
) -> Plan:
    """Return a plan from the files' texts; `names` are what errors call them."""
    called = {name: name for name in texts} | dict(names or {})
    protocol = parse_protocol(texts["protocol.toml"], called["protocol.toml"])
    sheets = parse_sheet(texts["sheet.toml"], called["sheet.toml"])
    optics = None
    if "optics.json" in texts:
        optics = Optics.from_json(texts["optics.json"], called["optics.json"])
    plan = Plan(
        rig=rig,
        protocol=protocol,
        sheets=sheets,
        calibration=_calibration(rig, texts["load_cell.toml"], called["load_cell.toml"]),
        optics=optics,
        schedule=protocol.schedule(called["protocol.toml"]),
        about=parse_about(texts.get(ABOUT, ""), called.get(ABOUT, ABOUT)),
        texts=dict(texts),
    )
    if CONTROLLER in texts:
        plan = _under_control(plan, called)
    _check_against_rig(plan, called)
    return plan


def _under_control(plan: Plan, called: Mapping[str, str]) -> Plan:
    """Return the plan with a controller in place of the protocol's pulses."""
    name = called[CONTROLLER]
    controller = parse_controller(plan.texts[CONTROLLER], name)
    require_fit(controller, name, plan.rig, plan.sheets, plan.calibration)
    reference = plan.texts[REFERENCE]
    schedule = controlled_schedule(plan.schedule, controller, reference, called)
    return replace(plan, controller=controller, schedule=schedule)


def _calibration(rig: RigConfig, text: str, name: str) -> LoadCellCalibration:
    calibration = parse_load_cell(text, name)
    return calibration.in_newtons() if rig.raw_force_unit == "N" else calibration


def _check_against_rig(plan: Plan, called: Mapping[str, str]) -> None:
    filmed = next((run for run in plan.schedule.runs if run.keep_all_frames), None)
    if filmed is not None and plan.rig.camera is None:
        raise BadInputError(
            f"{called['protocol.toml']}: [extras] {filmed.extra} is recorded by a camera, and the "
            "rig has none; add [camera] to rig.toml or remove the extra."
        )
    for run in plan.schedule.runs:
        if run.configuration not in plan.sheets:
            raise BadInputError(
                f"{called['protocol.toml']}: [[places]] configuration = {run.configuration!r} is "
                f"no table of {called['sheet.toml']}, which has {', '.join(plan.sheets)}."
            )
    limits = plan.rig.limits
    try:
        check_schedule(
            plan.schedule, SafetyLimits(limits.sheet_voltage_V, limits.time_under_voltage_s)
        )
    except ScheduleError as error:
        raise BadInputError(f"{called['protocol.toml']}: {error}.") from None
