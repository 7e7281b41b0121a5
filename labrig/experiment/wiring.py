"""From rig.toml to devices: the one place that knows whether hardware is real or simulated."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from drivers.boards.ni.connection import NiConnection
from drivers.cameras.choice import camera_for
from drivers.cameras.opencv import OpenCvCamera
from drivers.interfaces import Camera, Clock, Operator, Positioner, RealClock
from drivers.positioners.manual import ManualStage
from drivers.positioners.zaber import ZaberStage
from labrig.config import RigConfig
from labrig.errors import BadInputError
from labrig.experiment.plan import Plan
from labrig.experiment.rig import Rig, boards, interlock_of
from protocols import RecordedOperator
from protocols.execution.events import Event


def _nobody(_event: Event) -> None:
    """Nobody wants to know."""


SIMULATED = "simulated"
_DAY = 1_000_003  # from the seed of one session to that of the next


def wire(plan: Plan, operator: Operator, emit: Callable[[Event], None] = _nobody) -> Rig:
    """The rig that a plan's rig.toml describes, not opened; nothing is touched.

    What the operator is asked, and answers, is told by `emit`.
    """
    config = plan.rig
    if config.is_simulated:
        return _simulated(plan, emit)
    for key, value in _addresses(config):
        if value == SIMULATED:
            raise BadInputError(
                f'rig.toml: {key} = "simulated" needs [ni] address = "simulated"; a simulated '
                "device and real boards cannot share a clock."
            )
    clock = RealClock()
    connection = NiConnection(config.ni.address)
    output, signals = boards(config, connection, clock)
    asked = RecordedOperator(operator, clock, emit)
    return Rig(
        config=config,
        clock=clock,
        connection=connection,
        output=output,
        signals=signals,
        camera=_camera(config, clock, plan.schedule.frame_rate_hz),
        stage=_stage(plan, clock, asked),
        operator=asked,
        calibration=plan.calibration,
        interlock=interlock_of(config, connection, clock),
        threaded=True,
    )


def _addresses(config: RigConfig) -> list[tuple[str, object]]:
    camera = config.camera.source if config.camera else None
    return [("[camera] source", camera), ("[stage] port", config.stage.port)]


def _camera(config: RigConfig, clock: Clock, rate_hz: float) -> Camera | None:
    return None if config.camera is None else camera_for(config.camera.source, clock, rate_hz)


def _stage(
    plan: Plan,
    clock: Clock,
    operator: Operator,
    serial_factory: Callable[..., Any] | None = None,
) -> Positioner:
    stage = plan.rig.stage
    if stage.kind == "manual":
        return ManualStage(operator)
    if stage.port is None:
        raise BadInputError('rig.toml: [stage] port is missing; kind = "zaber" needs it.')
    return ZaberStage(
        stage.port,
        clock,
        plan.arc_radius_m,
        origin_rad=stage.origin_rad,
        device=stage.address,
        home_on_open=stage.home,
        operator=operator,
        serial_factory=serial_factory,
    )


def _world_file(config: RigConfig) -> object:
    return (config.simulated.world if config.simulated else None) or "world.toml"


def _simulated(plan: Plan, emit: Callable[[Event], None]) -> Rig:
    from sim_hardware.camera import SimulatedCapture
    from sim_hardware.clock import VirtualClock
    from sim_hardware.faults import FaultyRig
    from sim_hardware.operator import SimulatedOperator
    from sim_hardware.rig_boards import boards_of
    from sim_hardware.serial_devices import InMemorySerial
    from sim_hardware.serial_devices import SimulatedZaberStage as SimulatedStage
    from sim_hardware.world import World, WorldError, load_world

    config = plan.rig
    try:
        settings = load_world(config.simulated.world if config.simulated else None)
    except WorldError as error:
        raise BadInputError(str(error)) from None
    if plan.earlier:  # not the same set-ups and noise once more: another day, with the same sheet
        settings = settings.model_copy(
            update={"seed": (settings.seed + _DAY * plan.earlier) % 2**63}
        )
    clock = VirtualClock()
    world = World(settings, clock)
    try:
        server = boards_of(world, clock)
    except WorldError as error:
        raise BadInputError(f"{_world_file(config)}: {error}") from None
    faulty = FaultyRig(clock=clock, world=world, boards=server)
    faulty.begin()
    connection = NiConnection(SIMULATED, channel=server.in_process_channel())
    output, signals = boards(config, connection, clock)
    person = RecordedOperator(SimulatedOperator(world), clock, emit)
    camera = None
    if config.camera is not None:
        camera = OpenCvCamera(
            SIMULATED,
            clock,
            lambda _source: SimulatedCapture(world, clock, faults=faulty.camera),
        )

    def serial(port: str, **options: Any) -> Any:
        return InMemorySerial(
            SimulatedStage(world, clock, homed=True),
            clock,
            port=port,
            faults=faulty.serial,
            **options,
        )

    return Rig(
        config=config,
        clock=clock,
        connection=connection,
        output=output,
        signals=signals,
        camera=camera,
        stage=_stage(plan, clock, person, serial),
        operator=person,
        calibration=plan.calibration,
        interlock=interlock_of(config, connection, clock),
        threaded=False,
    )
