"""Simulated devices in place of hardware, where rig.toml says `simulated`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from drivers.cameras import CameraSettings
from drivers.cameras.capture_camera import CaptureCamera
from drivers.interfaces import FREE, AcquisitionSettings, Camera, Operator
from labrig.config.derived import SIMULATED
from labrig.errors import BadInputError
from labrig.experiment.plan import Plan
from sim_hardware.camera import SimulatedCapture
from sim_hardware.clock import VirtualClock
from sim_hardware.families import FOLDER as FAMILIES
from sim_hardware.families import BoardOptions, SimulatedBoards
from sim_hardware.faults import FaultyRig
from sim_hardware.operator import SimulatedOperator
from sim_hardware.plugins import UnknownPartError
from sim_hardware.serial_devices import FOLDER as SERIAL_DEVICES
from sim_hardware.serial_devices import InMemorySerial
from sim_hardware.world import World, WorldError, load_world

_CALLED = ("transport", "listen", "stop", "fault")
_DAY = 1_000_003  # from the seed of one session to that of the next


class StandIns:
    """A simulated rig: its clock, its operator, and what each driver reaches its device through."""

    def __init__(self, plan: Plan) -> None:
        simulated = plan.rig.simulated
        try:
            settings = load_world(simulated.world if simulated else None)
        except WorldError as error:
            raise BadInputError(str(error)) from None
        if plan.earlier:  # other set-ups and noise: another day, with the same sheet
            seed = (settings.seed + _DAY * plan.earlier) % 2**63
            settings = settings.model_copy(update={"seed": seed})
        self.clock = VirtualClock()
        self._seed = settings.seed
        self._plan = plan
        self._world = World(settings, self.clock)
        self._boards = self._boards_of(plan)
        self._faulty = FaultyRig(clock=self.clock, world=self._world, boards=self._boards)
        self._faulty.begin()
        self.operator: Operator = SimulatedOperator(self._world)

    def _boards_of(self, plan: Plan) -> SimulatedBoards:
        kind = plan.rig.boards_kind
        try:
            family = FAMILIES.get(kind)
        except UnknownPartError:
            there = ", ".join(sorted(FAMILIES.parts()))
            raise BadInputError(
                f"rig.toml: [{kind}] cannot be simulated; simulated are {there}."
            ) from None
        try:
            made = family.make(self._world, self.clock, BoardOptions())
        except WorldError as error:
            raise BadInputError(f"{_world_file(plan)}: {error}") from None
        lacks = [name for name in _CALLED if not callable(getattr(made, name, None))]
        if lacks:
            raise BadInputError(
                f"rig.toml: [{kind}] cannot be simulated: the make of its simulated family "
                f"returned {type(made).__name__}, which has no {', '.join(lacks)}."
            )
        return made

    def boards(self) -> Any:
        """Return the transport of the boards. None would have a driver reach real ones."""
        transport = self._boards.transport()
        if transport is None:
            raise BadInputError(
                f"rig.toml: [{self._plan.rig.boards_kind}] cannot be simulated in this program: "
                "the transport of its simulated family is None."
            )
        return transport

    def serial(self, table: str, kind: str) -> Callable[..., Any]:
        """Return what opens the serial line of a part, as pyserial's `Serial`."""
        try:
            device = SERIAL_DEVICES.get(kind)
        except UnknownPartError as error:
            raise BadInputError(f'rig.toml: [{table}] kind = "{kind}": {error}.') from None

        def opened(port: str, **options: Any) -> InMemorySerial:
            made = device.make(self._world, self.clock, self._seed)
            return InMemorySerial(
                made, self.clock, port=port, faults=self._faulty.serial, **options
            )

        return opened

    def camera(self) -> Camera:
        """Return the camera that shows the simulated sheet, whatever kind rig.toml names."""
        config = self._plan.rig.camera
        settings = config.settings() if config is not None else None
        wanted = AcquisitionSettings(trigger=FREE)
        if isinstance(settings, CameraSettings):
            wanted = settings.acquisition()
        self._refuse_settings(wanted)
        if wanted.exposure_s is not None:
            self._world.expose_for(wanted.exposure_s)

        def capture(_source: int | str) -> SimulatedCapture:
            made = SimulatedCapture(
                self._world,
                self.clock,
                faults=self._faulty.camera,
                trigger=wanted.trigger or FREE,
                exposure_s=self._world.exposure_s,
            )
            self._world.when_triggered(made.triggered)
            return made

        return CaptureCamera(SIMULATED, self.clock, capture)

    def _refuse_settings(self, wanted: AcquisitionSettings) -> None:
        rows, columns = self._world.frame_shape
        rate_hz = self._world.frame_rate_hz
        can = {
            "gain": (None,),
            "pixel_format": (None, "Mono8"),
            "region": (None, (0, 0, columns, rows)),
            "frame_rate_hz": (None, rate_hz),
        }
        for name, possible in can.items():
            if getattr(wanted, name) not in possible:
                raise BadInputError(
                    f"rig.toml: [camera] {name}: the simulated camera sends {columns} x {rows} "
                    f"Mono8 at {rate_hz:g} frames/s, without gain; remove the key."
                )
        if wanted.trigger == FREE and (wanted.exposure_s or 0.0) > 1 / rate_hz:
            raise BadInputError(
                f"rig.toml: [camera] exposure_s = {wanted.exposure_s:g} is longer than the time "
                f"between two frames of the simulated camera ({1 / rate_hz:g} s)."
            )


def _world_file(plan: Plan) -> str:
    simulated = plan.rig.simulated
    return str((simulated.world if simulated else None) or "world.toml")


def true_moving_sheet(world: Path, configuration: str) -> dict[str, float]:
    """Return what a moving world holds of a sheet, by the names that identification uses, in SI.

    For demonstrations: nothing of it enters a session.
    """
    settings = load_world(world)
    sheet, line = settings.configurations[configuration], settings.electrodes
    width_m, thickness_m = 1e-3 * sheet.width_mm, 1e-3 * sheet.thickness_mm
    B_Nm2 = 1e6 * sheet.youngs_modulus_MPa * width_m * thickness_m**3 / 12
    alpha_Nm = line.curvature_per_V_per_m * sheet.eibm_ratio * B_Nm2
    found = {
        "B": B_Nm2,
        "mass_per_length": settings.mass.density_kg_per_m3 * width_m * thickness_m,
        "viscous_time": 1e-3 * settings.loss.viscous_ms,
        "electrode_resistance": line.ohm_per_m,
        "capacitance": line.capacitance_F_per_m,
        "bulk_resistance": line.bulk_ohm_m,
        "leak": line.leak_S_per_m,
        "moment_per_positive_volt": alpha_Nm,
        "moment_per_negative_volt": alpha_Nm * settings.eibm.negative_ratio,
    }
    terms = zip(settings.loss.shares, settings.loss.times_s, strict=True)
    for number, (share, time_s) in enumerate(terms, 1):
        found |= {f"share_{number}": share, f"time_{number}": time_s}
    return found
