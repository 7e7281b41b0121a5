"""The boards in the simulated computer, and the physical channels that they have."""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from sim_hardware.ni.boards import board_model
from sim_hardware.ni.boards.contract import BoardModel, DigitalPort
from sim_hardware.ni.errors import Code, StatusError
from sim_hardware.ni.names import split_device

_IN_CHASSIS = re.compile(r"^(.+)Mod([1-9][0-9]?)$")


@dataclass(frozen=True)
class Device:
    """A board in the computer, by the name that its owner gave it."""

    name: str
    board: BoardModel

    @property
    def chassis(self) -> tuple[str, int] | None:
        """Name of its chassis and its slot, from a name such as cDAQ1Mod1.

        None: it has none, or it was given another name, which does not tell.
        """
        found = _IN_CHASSIS.match(self.name) if self.board.in_chassis else None
        return found and (found[1], int(found[2]))

    @property
    def engine_name(self) -> str:
        """The device with the timing engine, which its terminals belong to."""
        return self.chassis[0] if self.chassis else self.name

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
        """`models` maps a device's name to its product type; UnknownPartError for another.

        ValueError for a module whose name has a chassis or slot that is not there.
        """
        self._devices = {
            name.lower(): Device(name, board_model(model)) for name, model in models.items()
        }
        for device in self._devices.values():
            if device.chassis is not None:
                self._check_slot(device, *device.chassis)

    def __iter__(self) -> Iterator[Device]:
        return iter(self._devices.values())

    def _check_slot(self, module: Device, chassis: str, slot: int) -> None:
        holder = self._devices.get(chassis.lower())
        if holder is None or not 1 <= slot <= holder.board.slots:
            raise ValueError(
                f"{module.name} is a module in slot {slot} of the chassis {chassis}, which is not "
                f"there or has no such slot: name one too, such as {chassis}=cDAQ-9174"
            )

    def modules(self, chassis: Device) -> list[Device]:
        """Return the modules in a chassis."""
        return [device for device in self if (device.chassis or ("",))[0] == chassis.name]

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
