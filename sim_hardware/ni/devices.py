"""The boards in the simulated computer, and the physical channels that they have."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from sim_hardware.ni.boards import board_model
from sim_hardware.ni.boards.contract import BoardModel, DigitalPort
from sim_hardware.ni.errors import Code, StatusError
from sim_hardware.ni.names import split_device


@dataclass(frozen=True)
class Device:
    """A board in the computer, by the name that its owner gave it."""

    name: str
    board: BoardModel

    @property
    def serial_number(self) -> int:
        """Differs from device to device, and is the same every time."""
        return zlib.crc32(self.name.encode()) & 0x7FFFFFFF

    def inputs(self) -> list[str]:
        """Physical analog inputs."""
        side = self.board.analog_in
        return [f"{self.name}/ai{i}" for i in range(side.channels)] if side else []

    def outputs(self) -> list[str]:
        """Physical analog outputs."""
        side = self.board.analog_out
        return [f"{self.name}/ao{i}" for i in range(side.channels)] if side else []

    def ports(self, *, output: bool) -> list[str]:
        """Digital ports that can be read, or written."""
        return [
            f"{self.name}/port{i}"
            for i, port in enumerate(self.board.ports)
            if (port.outputs if output else port.inputs)
        ]

    def lines(self, *, output: bool) -> list[str]:
        """Digital lines that can be read, or written."""
        return [
            f"{port}/line{line}"
            for port in self.ports(output=output)
            for line in range(self.port_of(port.partition("/")[2]).lines)
        ]

    def port_of(self, line: str) -> DigitalPort:
        """Return the port of a line such as `port0/line3`."""
        port, _, _ = line.partition("/")
        return self.board.ports[int(port.removeprefix("port"))]

    def has(self, channel: str) -> bool:
        """Return whether there is such a channel (`ai0`), whatever its type."""
        name = f"{self.name}/{channel}"
        digital = self.lines(output=False) + self.lines(output=True)
        return name in self.inputs() + self.outputs() + digital


class DeviceRegistry:
    """All boards, found by name without regard to case, as the driver does."""

    def __init__(self, models: Mapping[str, str]) -> None:
        """`models` maps a device's name to its product type; UnknownPartError for another."""
        self._devices = {
            name.lower(): Device(name, board_model(model)) for name, model in models.items()
        }

    def __iter__(self) -> Iterator[Device]:
        return iter(self._devices.values())

    def find(self, name: str) -> Device:
        """Return the device of that name; -200220 when there is none."""
        device = self._devices.get(name.strip().lstrip("/").lower())
        if device is None:
            raise StatusError(Code.NO_SUCH_DEVICE, f"Device Specified: {name}")
        return device

    def find_channel(self, name: str) -> tuple[Device, str]:
        """Device and channel of a physical name; -200220, -200170 when there is none."""
        device_name, channel = split_device(name)
        device = self.find(device_name)
        channel = channel.lower()
        if not device.has(channel):
            raise StatusError(
                Code.NO_SUCH_CHANNEL,
                f"Physical Channel Name: {channel}\nDevice: {device.name}",
            )
        return device, channel
