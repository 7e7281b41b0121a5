"""Make a rig's devices from rig.toml; no other module knows whether they are real or simulated."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from inspect import getattr_static
from typing import TYPE_CHECKING, Any, cast

from drivers.amplifier import Amplifier, SheetDrive
from drivers.boards import BOARD_FAMILIES, BoardConnection
from drivers.cameras import CAMERAS, SoftwareTrigger
from drivers.cameras.conformance import METHODS as CAMERA_METHODS
from drivers.force_sensors import FORCE_SENSORS
from drivers.force_sensors.conformance import METHODS as FORCE_SENSOR_METHODS
from drivers.force_sensors.metered_input import MeteredInput
from drivers.interfaces import (
    FREE,
    SOFTWARE,
    Camera,
    Clock,
    DeviceError,
    FrameTrigger,
    Operator,
    Positioner,
    RealClock,
    SignalInput,
    TriggersFrames,
)
from drivers.plugins import PluginFolder
from drivers.positioners import POSITIONERS
from drivers.positioners.conformance import METHODS as POSITIONER_METHODS
from drivers.positioners.contract import Surroundings
from labrig.config import RigConfig
from labrig.config.derived import SIMULATED
from labrig.errors import BadInputError, LabrigError, NotReadyError
from labrig.experiment.plan import Plan
from labrig.experiment.rig.channels import inputs_of
from labrig.experiment.rig.rig import FORCE, Rig
from labrig.foreign_code import foreign_place
from protocols import RecordedOperator
from protocols.execution.events import Event

if TYPE_CHECKING:
    from labrig.experiment.rig.stand_ins import StandIns


def _nobody(_event: Event) -> None:
    """Nobody wants to know."""


def wire(plan: Plan, operator: Operator, emit: Callable[[Event], None] = _nobody) -> Rig:
    """Return the rig that a plan's rig.toml describes, not opened; nothing is touched.

    What the operator is asked, and answers, is published by `emit`.
    """
    config = plan.rig
    _refuse_unsafe_boards(config)
    _refuse_mixture(config)
    if config.is_simulated:
        from labrig.experiment.rig.stand_ins import StandIns  # slow to import

        stand_ins = StandIns(plan)
        return _wired(plan, stand_ins.clock, stand_ins.operator, emit, stand_ins)
    return _wired(plan, RealClock(), operator, emit, None)


def _refuse_unsafe_boards(config: RigConfig) -> None:
    if config.family.rescue is None:
        raise BadInputError(
            f"rig.toml: the boards of [{config.boards_kind}] cannot be made safe by another "
            "process when this one fails, so no sheet is driven with them; use other boards."
        )


def _refuse_mixture(config: RigConfig) -> None:
    for key, value in _addresses(config):
        if value is None or (value == SIMULATED) is config.is_simulated:
            continue
        if config.is_simulated:
            raise BadInputError(
                f"rig.toml: {key} = {json.dumps(value)} is real and [{config.boards_kind}] address "
                'is "simulated"; set it to "simulated" too.'
            )
        raise BadInputError(
            f'rig.toml: {key} = "simulated" needs [{config.boards_kind}] address = '
            '"simulated"; a simulated device and real boards cannot share a clock.'
        )


def _addresses(config: RigConfig) -> Iterator[tuple[str, object]]:
    yield "[camera] source", config.camera.source if config.camera else None
    yield "[stage] port", getattr(config.stage, "port", None)
    yield "[force_sensor] port", getattr(config.force_sensor, "port", None)


@contextmanager
def _part(folder: PluginFolder[Any], kind: str) -> Iterator[None]:
    """Name the part whose code raises what no contract knows."""
    try:
        yield
    except (DeviceError, LabrigError):
        raise
    except (Exception, SystemExit) as fault:
        place = foreign_place(fault)
        where = "" if place is None else f", in {place}"
        raise NotReadyError(
            f"{_named(folder, kind)} cannot be used: {type(fault).__name__}: {fault}{where}"
        ) from fault


def _complete(folder: PluginFolder[Any], kind: str, made: object, methods: tuple[str, ...]) -> Any:
    """Return a device that a part has made, where it has what labrig calls.

    Without this a camera that is None would be none: a session without images.
    """
    # statically: a property may ask a device that is not open yet
    lacks = [name for name in methods if getattr_static(made, name, None) is None]
    lacks = [name for name in lacks if not hasattr(made, name)]  # one that hands everything on
    if lacks:
        what = "None" if made is None else type(made).__name__
        raise NotReadyError(
            f"{_named(folder, kind)} cannot be used: its make returned {what}, which has no "
            f"{', '.join(lacks)}"
        )
    return made


def _named(folder: PluginFolder[Any], kind: str) -> str:
    origin = folder.origins().get(kind)
    return f"the {folder.what} '{kind}'{f' of {origin}' if origin else ''}"


def _wired(
    plan: Plan,
    clock: Clock,
    operator: Operator,
    emit: Callable[[Event], None],
    stand_ins: StandIns | None,
) -> Rig:
    config = plan.rig
    transport = stand_ins.boards() if stand_ins else None
    with _part(BOARD_FAMILIES, config.boards_kind):
        boards = config.family.connect(config.boards.settings(), clock, transport)
    asked = RecordedOperator(operator, clock, emit)
    with _part(BOARD_FAMILIES, config.boards_kind):
        output = sheet_drive(config, boards)
        interlock = None
        if config.interlock is not None or config.own_watchdog:
            interlock = boards.interlock(config.interlock_line)
    camera = _camera(plan, clock, stand_ins)
    return Rig(
        config=config,
        clock=clock,
        boards=boards,
        output=output,
        signals=_signals(config, boards, clock, stand_ins),
        camera=camera,
        trigger=_trigger(config, boards, camera),
        stage=_stage(plan, clock, asked, stand_ins),
        operator=asked,
        calibration=plan.calibration,
        interlock=interlock,
        threaded=stand_ins is None,
    )


def sheet_drive(config: RigConfig, boards: BoardConnection) -> SheetDrive:
    """Return the output in sheet volts, through the amplifier."""
    amplifier = Amplifier(config.amplifier.gain, config.limits.sheet_voltage_V)
    return SheetDrive(boards.voltage_output(amplifier.limit_board_V), amplifier)


def _signals(
    config: RigConfig, boards: BoardConnection, clock: Clock, stand_ins: StandIns | None
) -> SignalInput:
    """Return the board's inputs; a meter takes the place of the force's."""
    inputs = inputs_of(config)
    sensor = config.force_sensor
    make = FORCE_SENSORS.get(sensor.kind).make
    by_board = [each for each in inputs if make is None or each.name != FORCE]
    with _part(BOARD_FAMILIES, config.boards_kind):
        read = boards.signal_input(by_board)
    if make is None:
        return read
    with _part(FORCE_SENSORS, sensor.kind):
        meter = make(sensor.settings(), clock, _line(stand_ins, "force_sensor", sensor.kind))
    meter = _complete(FORCE_SENSORS, sensor.kind, meter, (*FORCE_SENSOR_METHODS, "range_N"))
    return MeteredInput(read, meter, clock, sensor.kind)


def _camera(plan: Plan, clock: Clock, stand_ins: StandIns | None) -> Camera | None:
    camera = plan.rig.camera
    if camera is None:
        return None
    if stand_ins is not None:
        return stand_ins.camera()
    make = CAMERAS.get(camera.kind).make
    with _part(CAMERAS, camera.kind):
        made = make(camera.settings(), clock, plan.schedule.frame_rate_hz)
    return cast("Camera", _complete(CAMERAS, camera.kind, made, CAMERA_METHODS))


def _trigger(
    config: RigConfig, boards: BoardConnection, camera: Camera | None
) -> FrameTrigger | None:
    """Return what begins the camera's exposures; None: it runs free."""
    if camera is None or config.camera is None:
        return None
    if config.trigger_line is not None:
        if not isinstance(boards, TriggersFrames):
            raise BadInputError(
                f"rig.toml: the boards of [{config.boards_kind}] have no line that triggers a "
                'camera; set [camera] trigger = "free" or "software".'
            )
        with _part(BOARD_FAMILIES, config.boards_kind):
            return boards.frame_trigger(config.trigger_line)
    is_software = getattr(config.camera, "trigger", FREE) == SOFTWARE
    return SoftwareTrigger(camera) if is_software else None


def _stage(plan: Plan, clock: Clock, operator: Operator, stand_ins: StandIns | None) -> Positioner:
    stage = plan.rig.stage
    around = Surroundings(
        clock=clock,
        operator=operator,
        arc_radius_m=plan.arc_radius_m,
        transport=_line(stand_ins, "stage", stage.kind) if hasattr(stage, "port") else None,
    )
    with _part(POSITIONERS, stage.kind):
        made = POSITIONERS.get(stage.kind).make(stage.settings(), around)
    return cast("Positioner", _complete(POSITIONERS, stage.kind, made, POSITIONER_METHODS))


def _line(stand_ins: StandIns | None, table: str, kind: str) -> Callable[..., Any] | None:
    """Return what opens a part's serial line; None: the real one."""
    return None if stand_ins is None else stand_ins.serial(table, kind)
