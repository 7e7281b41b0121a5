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
    FrameTrigger,
    Interlock,
    Operator,
    Positioner,
    SignalInput,
    VoltageOutput,
)
from drivers.load_cell import LoadCell, LoadCellCalibration
from labrig.config import RigConfig
from labrig.errors import NotReadyError, OutputUnknownError
from labrig.experiment.rig.channels import channels_of
from labrig.foreign_code import foreign_place
from labrig.session import RecordedSession
from protocols.execution.devices import Devices

__all__ = ["CURRENT", "DRIVE", "FORCE", "Rig", "opened"]


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
            operator=self.operator,
            channels=channels_of(self.config, load_cell, ranges_V),
            protect=load_cell.protect,
        )


@contextmanager
def opened(rig: Rig, on_step: Step = no_step) -> Iterator[Rig]:
    """Open every device of a rig; they are closed in reverse order, whatever happens.

    `on_step` is called before each.

    A device that cannot be opened raises NotReadyError with the driver's sentence: nothing has been
    energised. The output is opened first and closed last, and both write 0 V; OutputUnknownError
    when that fails at the end. The other devices' faults at the end do not matter any more.
    """
    releases: list[Callable[[], None]] = []
    try:
        for what, take, release in _openings(rig):
            on_step(f"opening {what}")
            try:
                take()
            except DeviceError as fault:
                raise NotReadyError(str(fault)) from fault
            except (Exception, SystemExit) as fault:
                raise NotReadyError(_unexpected(what, fault)) from fault
            releases.append(release)
        yield rig
    finally:
        _release(rig, releases)


def _unexpected(what: str, fault: BaseException) -> str:
    """Return what a device raised that no driver may raise, and in whose code."""
    place = foreign_place(fault)
    where = "" if place is None else f", in {place}"
    return f"opening {what} failed: {type(fault).__name__}: {fault}{where}"


def _release(rig: Rig, releases: list[Callable[[], None]]) -> None:
    unknown: BaseException | None = None
    for release in reversed(releases):
        try:
            release()
        except (Exception, SystemExit) as fault:  # noqa: BLE001 - whatever a device raises, the next is released
            if release == rig.output.close:
                unknown = fault
    if unknown is not None:
        raise OutputUnknownError(f"{unknown}; switch the amplifier off") from unknown


def _openings(rig: Rig) -> Iterator[tuple[str, Callable[[], None], Callable[[], None]]]:
    yield "the boards", rig.boards.open, rig.boards.close
    yield "the output, at 0 V", rig.output.open, rig.output.close
    yield "the inputs", rig.signals.open, rig.signals.close
    if rig.camera is not None:
        yield "the camera", rig.camera.open, rig.camera.close
    if rig.trigger is not None:
        yield "the camera's trigger", rig.trigger.open, rig.trigger.close
    yield "the stage", rig.stage.open, rig.stage.close
