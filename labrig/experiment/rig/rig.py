"""An opened rig: every device that rig.toml names, ready to run a schedule."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from drivers.boards.contract import CURRENT, DRIVE, FORCE, BoardConnection
from drivers.force_sensors.metered_input import MeteredInput
from drivers.interfaces import (
    Camera,
    Clock,
    DeviceError,
    DeviceTimeoutError,
    FrameTrigger,
    Interlock,
    Operator,
    Positioner,
    SignalInput,
    VoltageOutput,
)
from drivers.load_cell import LoadCell, LoadCellCalibration
from drivers.safe_shutdown import in_time
from labrig.config import RigConfig
from labrig.errors import LabrigWarning, NotReadyError, OutputUnknownError, warn_caller
from labrig.experiment.rig.channels import channels_of
from labrig.foreign_code import device_sentence, foreign_place
from labrig.session import RecordedSession
from labrig.session.recording.disk import note_a_device_left_behind
from protocols.execution.devices import Devices

__all__ = ["CURRENT", "DRIVE", "FORCE", "Rig", "opened", "unexpected"]

# A device that has not closed after so long is left behind; ours end a last request within 5 s.
CLOSE_S = 8.0

Step = Callable[[str], None]  # called with what is done next, in words


def no_step(_text: str) -> None:
    """Nobody wants to know what is done next."""


@dataclass(frozen=True, kw_only=True)
class Rig:
    """The devices of a rig and what stands around them. Made by `wiring`, opened by `opened`."""

    config: RigConfig
    clock: Clock
    boards: BoardConnection
    output: VoltageOutput
    signals: SignalInput
    camera: Camera | None
    stage: Positioner
    operator: Operator
    calibration: LoadCellCalibration  # of the channel `force`: its unit may be the newton itself
    trigger: FrameTrigger | None = None  # what begins the camera's exposures; None: it runs free
    interlock: Interlock | None  # opened only while a run is watched over
    threaded: bool  # False on a virtual clock: whatever follows the run is called at once
    replayed: RecordedSession | None = None  # the session that plays in the devices' place

    @property
    def read_back(self) -> SignalInput:
        """The inputs that making safe reads: the board's own, which need no meter."""
        return self.signals.board if isinstance(self.signals, MeteredInput) else self.signals

    @property
    def load_cell(self) -> LoadCell:
        """The load cell on the input range that it really has (once it is open)."""
        row = list(self.signals.channels).index(FORCE)
        return LoadCell(self.calibration, self.signals.ranges_V[row], self.config.raw_force_unit)

    def devices(self) -> Devices:
        """As the scheduler takes them; the rig must be open."""
        load_cell = self.load_cell
        ranges_V = dict(zip(self.signals.channels, self.signals.ranges_V, strict=True))
        return Devices(
            output=self.output,
            signals=self.signals,
            camera=self.camera,
            trigger=self.trigger,
            stage=self.stage,
            stage_name=self.config.stage.kind,
            operator=self.operator,
            channels=channels_of(self.config, load_cell, ranges_V),
            protect=load_cell.protect,
        )


@contextmanager
def opened(rig: Rig, on_step: Step = no_step) -> Iterator[Rig]:
    """Open every device of a rig; they are closed at the end, whatever happens.

    `on_step` is called before each.

    The boards are closed first: whatever becomes of the other devices, the next program can have
    them. A device that does not close in `CLOSE_S` is left behind, with a LabrigWarning.

    A device that cannot be opened raises NotReadyError with the driver's sentence: nothing has been
    energised. Opening and closing the output both write 0 V; OutputUnknownError when that fails at
    the end. The other devices' faults at the end do not matter any more.
    """
    taken: list[_Device] = []
    try:
        for device in _devices(rig):
            on_step(f"opening {device.what}")
            try:
                device.take()
            except DeviceError as fault:
                raise NotReadyError(device_sentence(fault)) from fault
            except (Exception, SystemExit) as fault:
                raise NotReadyError(unexpected(f"opening {device.what}", fault)) from fault
            taken.append(device)
        yield rig
    finally:
        _release(rig, taken)


def unexpected(doing: str, fault: BaseException) -> str:
    """Return what a device raised that no driver may raise, and in whose code."""
    place = foreign_place(fault)
    where = "" if place is None else f", in {place}"
    return f"{doing} failed: {type(fault).__name__}: {fault}{where}"


@dataclass(frozen=True)
class _Device:
    what: str
    take: Callable[[], None]
    release: Callable[[], None]
    of_boards: bool = True


def _release(rig: Rig, taken: list[_Device]) -> None:
    unknown: BaseException | None = None
    late: list[str] = []
    last_first = taken[::-1]
    boards = [device for device in last_first if device.of_boards]
    for device in boards + [device for device in last_first if not device.of_boards]:
        closing = f"closing {device.what.partition(',')[0]}"
        try:
            in_time(rig.clock, closing, device.release, CLOSE_S)
        except (Exception, SystemExit) as fault:  # noqa: BLE001 - the next one is released
            if isinstance(fault, DeviceTimeoutError):
                note_a_device_left_behind()
                late.append(str(fault).rstrip("."))
            if device.release == rig.output.close:
                unknown = fault
    try:
        for said in late:
            warn_caller(LabrigWarning(f"warning: {said}."))
    finally:
        if unknown is not None:
            raise OutputUnknownError(f"{unknown}; switch the amplifier off") from unknown


def _devices(rig: Rig) -> Iterator[_Device]:
    """Yield the devices in the order in which they are opened."""
    yield _Device("the boards", rig.boards.open, rig.boards.close)
    yield _Device("the output, at 0 V", rig.output.open, rig.output.close)
    yield _Device("the inputs", rig.signals.open, rig.signals.close)
    if rig.camera is not None:
        yield _Device("the camera", rig.camera.open, rig.camera.close, of_boards=False)
    if rig.trigger is not None:
        yield _Device("the camera's trigger", rig.trigger.open, rig.trigger.close)
    yield _Device("the stage", rig.stage.open, rig.stage.close, of_boards=False)
