"""An opened rig: every device that rig.toml names, ready to run a schedule."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from drivers.amplifier import Amplifier, SheetDrive
from drivers.boards.ni.analog_input import InputChannel, NiSignalInput
from drivers.boards.ni.analog_output import NiVoltageOutput
from drivers.boards.ni.connection import NiConnection
from drivers.boards.ni.interlock import NiInterlock
from drivers.force_sensors.load_cell import LoadCell, LoadCellCalibration
from drivers.interfaces import Camera, Clock, DeviceError, Operator, Positioner
from labrig.config import RigConfig
from labrig.errors import NotReadyError, OutputUnknownError
from labrig.experiment.channels import channels_of, inputs_of
from protocols.execution.devices import Devices

DRIVE = "drive"  # the channel on which the sheet voltage is read back


@dataclass(frozen=True)
class Rig:
    """The devices of a rig and what stands around them. Made by `wiring`, opened by `opened`."""

    config: RigConfig
    clock: Clock
    connection: NiConnection
    output: SheetDrive
    signals: NiSignalInput
    camera: Camera | None
    stage: Positioner
    operator: Operator
    calibration: LoadCellCalibration
    interlock: NiInterlock | None  # opened only while a run is watched over
    threaded: bool  # False on a virtual clock: whatever follows the run is called at once

    @property
    def load_cell(self) -> LoadCell:
        """The load cell on the input range that the board really has (once it is open)."""
        row = list(self.signals.channels).index("force")
        return LoadCell(self.calibration, self.signals.ranges_V[row])

    def devices(self) -> Devices:
        """As the scheduler takes them; the rig must be open."""
        load_cell = self.load_cell
        ranges_V = dict(zip(self.signals.channels, self.signals.ranges_V, strict=True))
        return Devices(
            output=self.output,
            signals=self.signals,
            camera=self.camera,
            stage=self.stage,
            operator=self.operator,
            channels=channels_of(self.config, load_cell, ranges_V),
            protect=load_cell.protect,
        )


def boards(
    config: RigConfig, connection: NiConnection, clock: Clock
) -> tuple[SheetDrive, NiSignalInput]:
    """The drivers of the output and of the inputs, not opened."""
    ni = config.ni
    amplifier = Amplifier(config.amplifier.gain, config.limits.sheet_voltage_V)
    output = NiVoltageOutput(
        connection, clock, ni.drive, amplifier.limit_board_V, ni.task_names.output
    )
    channels = [InputChannel(*each, "differential") for each in inputs_of(config)]
    signals = NiSignalInput(connection, clock, channels, ni.sample_rate_hz, ni.task_names.input)
    return SheetDrive(output, amplifier), signals


def interlock_of(config: RigConfig, connection: NiConnection, clock: Clock) -> NiInterlock | None:
    """The driver of the line that keeps an external interlock closed, where the rig has one."""
    if config.interlock is None:
        return None
    return NiInterlock(connection, clock, config.interlock.line, config.ni.task_names.interlock)


@contextmanager
def opened(rig: Rig) -> Iterator[Rig]:
    """The same rig with every device open; they are closed in reverse order, whatever happens.

    A device that cannot be taken raises NotReadyError with the driver's sentence: nothing has been
    energised. The output is opened first and closed last, and both write 0 V; OutputUnknownError
    when that fails at the end. The other devices' faults at the end do not matter any more.
    """
    releases: list[Callable[[], None]] = []
    try:
        for take, release in _openings(rig):
            try:
                take()
            except DeviceError as fault:
                raise NotReadyError(str(fault)) from fault
            releases.append(release)
        yield rig
    finally:
        _release(rig, releases)


def _release(rig: Rig, releases: list[Callable[[], None]]) -> None:
    unknown: DeviceError | None = None
    for release in reversed(releases):
        try:
            release()
        except DeviceError as fault:
            if release == rig.output.close:
                unknown = fault
    if unknown is not None:
        raise OutputUnknownError(f"{unknown}; switch the amplifier off") from unknown


def _openings(rig: Rig) -> Iterator[tuple[Callable[[], None], Callable[[], None]]]:
    yield rig.connection.open, rig.connection.close
    yield rig.output.open, rig.output.close
    yield rig.signals.open, rig.signals.close
    if rig.camera is not None:
        yield rig.camera.open, rig.camera.close
    yield rig.stage.open, rig.stage.close
