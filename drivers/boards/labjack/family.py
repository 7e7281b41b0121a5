"""The family of LabJack T-series devices, as the contract has it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from drivers.boards.contract import (
    CURRENT,
    DRIVE,
    FORCE,
    BoardFamily,
    BoardFinding,
    BoardInput,
)
from drivers.boards.labjack.analog_input import LabJackSignalInput
from drivers.boards.labjack.analog_output import LabJackOutput, OffsetStage
from drivers.boards.labjack.device import LabJackDevice
from drivers.boards.labjack.registers import line_number, tick_dac_lines
from drivers.boards.labjack.rescue import LabJackPlace, LabJackRescue
from drivers.boards.labjack.settings import LabJackSettings, check_line
from drivers.boards.labjack.starter import STARTER
from drivers.boards.labjack.trigger import LabJackTrigger
from drivers.boards.labjack.watchdog import LabJackWatchdog, what_it_does
from drivers.boards.labjack.wire import Transport
from drivers.interfaces import Clock, DeviceError, DeviceIdentity, DeviceNotFoundError, Interlock


class LabJackBoards:
    """The device that one [labjack] table names. A `BoardConnection`."""

    def __init__(
        self,
        settings: LabJackSettings,
        clock: Clock,
        transport: Callable[[], Transport] | None,
    ) -> None:
        self.settings = settings
        self._clock = clock
        self._device = LabJackDevice(settings.address, clock, transport)
        self._simulated = transport is not None
        self._output: LabJackOutput | None = None

    def open(self) -> None:
        """See `BoardConnection.open`. A device that is another one is refused."""
        self._device.open()
        wanted, device = self.settings, self._device
        if wanted.serial not in (None, device.serial):
            raise DeviceNotFoundError(
                f"{device.wire.where} has the serial number {device.serial}, rig.toml says "
                f"{wanted.serial}; correct [labjack] address or serial"
            )
        if device.model.name != wanted.model:
            raise DeviceNotFoundError(
                f"{device.wire.where} is a {device.model.name}, rig.toml says {wanted.model}; "
                "correct [labjack] address or model"
            )

    def findings(self) -> Sequence[BoardFinding]:
        """See `BoardConnection.findings`."""
        device, wanted = self._device, self.settings
        serial = "any serial number" if wanted.serial is None else f"serial {wanted.serial}"
        found = f"{device.model.name}, serial {device.serial}, firmware {device.firmware:.4g}"
        return [BoardFinding("LabJack", ok=True, found=found, wanted=f"{wanted.model}, {serial}")]

    def identities(self) -> Sequence[DeviceIdentity]:
        """See `Identified.identities`."""
        device = self._device
        return [
            DeviceIdentity(
                name=self.settings.address,
                maker="LabJack",
                product=device.model.name,
                serial=str(device.serial),
                driver=f"firmware {device.firmware:.4g}",
                is_simulated=True if self._simulated else None,
            )
        ]

    def voltage_output(self, limit_V: float) -> LabJackOutput:
        """See `BoardConnection.voltage_output`."""
        self._output = LabJackOutput(self._device, self._clock, stage_of(self.settings), limit_V)
        return self._output

    def signal_input(self, inputs: Sequence[BoardInput]) -> LabJackSignalInput:
        """See `BoardConnection.signal_input`."""
        return LabJackSignalInput(self._device, self._clock, inputs, self.settings.sample_rate_hz)

    def interlock(self, line: str | None) -> Interlock:
        """See `BoardConnection.interlock`."""
        if line is not None:
            self._require_free(line)
        stage = stage_of(self.settings)
        return LabJackWatchdog(self._device, self._clock, line, stage, self._check_mark)

    def frame_trigger(self, line: str) -> LabJackTrigger:
        """See `TriggersFrames.frame_trigger`."""
        self._require_free(line)
        return LabJackTrigger(self._device, self._clock, line)

    def _require_free(self, line: str) -> None:
        """Refuse a line that carries the values of the output."""
        drive = self.settings.drive
        if line_number(line) in tick_dac_lines(drive):
            raise DeviceError(
                f"the line {line} belongs to the LJTick-DAC of [labjack] drive = {drive}; choose "
                "another line for the interlock or the trigger"
            )

    def close(self) -> None:
        """See `BoardConnection.close`."""
        self._device.close()

    def _check_mark(self, mark: float) -> bool:
        """Without an output there is no mark to keep."""
        return self._output is None or self._output.check_mark(mark)


def stage_of(settings: LabJackSettings) -> OffsetStage:
    """Return what is between the device and the amplifier."""
    return OffsetStage(settings.drive, settings.zero_V, settings.stage_gain)


def _inputs(settings: LabJackSettings) -> tuple[BoardInput, ...]:
    ranges_V = settings.ranges_V
    return (
        BoardInput(FORCE, settings.force, ranges_V.force),
        BoardInput(CURRENT, settings.current, ranges_V.current),
        BoardInput(DRIVE, settings.drive_readback, ranges_V.drive),
    )


def _output_place(
    settings: LabJackSettings, limit_V: float, safe_below_V: float, line: str | None
) -> dict[str, Any]:
    del limit_V  # 0 V is all that a rescue writes
    return LabJackPlace(
        address=settings.address,
        terminal=settings.drive,
        zero_V=settings.zero_V,
        gain=settings.stage_gain,
        drive=settings.drive_readback,
        drive_range_V=settings.ranges_V.drive,
        safe_below_V=safe_below_V,
        line=line,
    ).as_dict()


def _rescue(place: Mapping[str, Any], clock: Clock) -> LabJackRescue:
    try:
        return LabJackRescue(LabJackPlace(**place), clock)
    except TypeError as fault:
        raise DeviceError(f"the place of the output cannot be read: {fault}") from fault


def _own_watchdog(settings: LabJackSettings, line: str | None) -> str:
    return what_it_does(stage_of(settings), line)


BOARDS = BoardFamily(
    kind="labjack",
    help="LabJack T4, T7 or T8 over Modbus TCP",
    settings=LabJackSettings,
    connect=LabJackBoards,
    inputs=_inputs,
    output_place=_output_place,
    rescue=_rescue,
    check_line=check_line,
    own_watchdog=_own_watchdog,
    starter=STARTER,
)
