"""The family of NI boards, as the contract has it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from drivers.boards.contract import (
    CURRENT,
    DRIVE,
    FORCE,
    BoardFamily,
    BoardFinding,
    BoardInput,
)
from drivers.boards.ni.analog_input import InputChannel, NiSignalInput
from drivers.boards.ni.analog_output import NiVoltageOutput
from drivers.boards.ni.connection import NiConnection
from drivers.boards.ni.interlock import NiInterlock
from drivers.boards.ni.rescue import NiRescue, OutputPlace
from drivers.boards.ni.settings import NiSettings, check_line
from drivers.boards.ni.trigger import NiTrigger
from drivers.interfaces import Clock, DeviceError, DeviceIdentity


class NiBoards:
    """The boards that one [ni] table names. A `BoardConnection`."""

    def __init__(self, settings: NiSettings, connection: NiConnection, clock: Clock) -> None:
        self.settings = settings
        self.connection = connection
        self._clock = clock

    def open(self) -> None:
        """See `BoardConnection.open`."""
        self.connection.open()

    def findings(self) -> Sequence[BoardFinding]:
        """See `BoardConnection.findings`."""
        types = {device.name: device.product_type for device in self.connection.devices()}
        wired = (("drive board", self.settings.drive), ("input board", self.settings.force))
        return [_finding(name, channel, types) for name, channel in wired]

    def identities(self) -> Sequence[DeviceIdentity]:
        """See `Identified.identities`: of each board that is wired, in the order of the keys."""
        wired = self.settings
        channels = (wired.drive, wired.force, wired.current, wired.drive_readback)
        names = dict.fromkeys(channel.split("/")[0] for channel in channels)
        return [self.connection.identity(name) for name in names]

    def voltage_output(self, limit_V: float) -> NiVoltageOutput:
        """See `BoardConnection.voltage_output`."""
        names = self.settings.task_names
        channel = self.settings.drive
        return NiVoltageOutput(self.connection, self._clock, channel, limit_V, names.output)

    def signal_input(self, inputs: Sequence[BoardInput]) -> NiSignalInput:
        """See `BoardConnection.signal_input`."""
        rate_hz, name = self.settings.sample_rate_hz, self.settings.task_names.input
        channels = [InputChannel(*each, "differential") for each in inputs]
        return NiSignalInput(self.connection, self._clock, channels, rate_hz, name)

    def interlock(self, line: str | None) -> NiInterlock:
        """See `BoardConnection.interlock`."""
        if line is None:
            raise DeviceError("NI boards have no watchdog of their own: name the interlock's line")
        name = self.settings.task_names.interlock
        return NiInterlock(self.connection, self._clock, line, name)

    def frame_trigger(self, line: str) -> NiTrigger:
        """See `TriggersFrames.frame_trigger`."""
        return NiTrigger(self.connection, self._clock, line, self.settings.task_names.trigger)

    def close(self) -> None:
        """See `BoardConnection.close`."""
        self.connection.close()


def _finding(name: str, channel: str, types: Mapping[str, str]) -> BoardFinding:
    device, _, terminal = channel.partition("/")
    found = f"{device} is a {types[device]}" if device in types else "not there"
    return BoardFinding(name, device in types, found, f"{device} with {terminal}")


def _connect(settings: NiSettings, clock: Clock, channel: Any) -> NiBoards:
    """`channel`: a ready grpc.Channel, or None."""
    return NiBoards(settings, NiConnection(settings.address, channel=channel), clock)


def _inputs(settings: NiSettings) -> tuple[BoardInput, ...]:
    ranges_V = settings.ranges_V
    return (
        BoardInput(FORCE, settings.force, ranges_V.force),
        BoardInput(CURRENT, settings.current, ranges_V.current),
        BoardInput(DRIVE, settings.drive_readback, ranges_V.drive),
    )


def _output_place(
    settings: NiSettings, limit_V: float, safe_below_V: float, line: str | None
) -> dict[str, Any]:
    names = settings.task_names
    return OutputPlace(
        address=settings.address,
        output_channel=settings.drive,
        drive_channel=settings.drive_readback,
        limit_board_V=limit_V,
        drive_range_V=settings.ranges_V.drive,
        drive_terminals="differential",
        safe_below_V=safe_below_V,
        output_task=names.output,
        input_task=names.input,
        interlock_task=None if line is None else names.interlock,
    ).as_dict()


def _rescue(place: Mapping[str, Any], clock: Clock) -> NiRescue:
    try:
        return NiRescue(OutputPlace(**place), clock)
    except TypeError as fault:
        raise DeviceError(f"the place of the output cannot be read: {fault}") from fault


BOARDS = BoardFamily(
    kind="ni",
    help="National Instruments boards: local, or host:port of an NI gRPC Device Server",
    settings=NiSettings,
    connect=_connect,
    inputs=_inputs,
    output_place=_output_place,
    rescue=_rescue,
    check_line=check_line,
)
