"""The one place that knows whether NI boards are in this computer or behind a gRPC server.

Everything else asks an `NiConnection` for tasks and never sees an address.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass
from typing import Any, TypeVar

from drivers.boards.ni.errors import DeviceReservedError, ni_errors
from drivers.interfaces import DeviceError, DeviceIdentity, DeviceNotFoundError

T = TypeVar("T")
_HOST_PORT = re.compile(r"^(\[[0-9A-Fa-f:.]+\]|[^\s:/\[\]]+):(\d{1,5})$")


@dataclass(frozen=True)
class NiDevice:
    """A board as the driver lists it."""

    name: str  # PCI6703
    product_type: str  # PCI-6703


class NiConnection:
    """The NI-DAQmx driver of this computer ("local"), or an NI gRPC Device Server ("host:port").

    `channel`: a ready grpc.Channel instead (in-process use); then `address` is only its name. It
    is given our deadlines, too.
    """

    def __init__(self, address: str = "local", channel: Any = None) -> None:
        self.address = address
        self._own_channel = channel is None and address != "local"
        self._channel: Any = None
        if channel is not None:
            from drivers.boards.ni.deadlines import with_deadlines

            self._channel = with_deadlines(channel)
        if self._own_channel:
            _check_address(address)

    @property
    def is_local(self) -> bool:
        """Tasks belong to this process and cannot be attached to from another."""
        return self._channel is None and not self._own_channel

    @property
    def where(self) -> str:
        """The other end, as error texts name it."""
        if self.is_local:
            return "the NI-DAQmx driver of this computer"
        return f"the NI gRPC Device Server at {self.address}"

    def open(self) -> None:
        """Make sure that somebody answers. Raises DeviceNotFoundError, DeviceTimeoutError."""
        if self._own_channel and self._channel is None:
            from drivers.boards.ni.deadlines import channel_to

            self._channel = channel_to(self.address)
        try:
            self.driver_version()
        except DeviceError:
            self.close()
            raise

    def close(self) -> None:
        """Close a connection of our own. May be called twice."""
        if self._own_channel and self._channel is not None:
            self._channel.close()
            self._channel = None

    def errors(self, doing: str) -> AbstractContextManager[None]:
        """Inside it NI's exceptions become DeviceErrors whose text begins with `doing`."""
        return ni_errors(doing, self.where, self._device_names_or_none)

    def driver_version(self) -> str:
        """Version of the NI-DAQmx driver at the other end, such as 26.0."""
        with self.errors("asking for the driver's version"):
            version = self._system().driver_version
            return f"{version.major_version}.{version.minor_version}"

    def identity(self, name: str) -> DeviceIdentity:
        """Return what the driver reports of a board. What it cannot tell of this one stays empty.

        Raises DeviceError when nobody answers.
        """
        driver = f"NI-DAQmx {self.driver_version()}"
        with self.errors("asking for a board's identity"):
            device = self._system().devices[name]
        return DeviceIdentity(
            name=name,
            maker="National Instruments",
            product=str(self._told(lambda: device.product_type) or ""),
            serial=_serial(self._told(lambda: device.serial_num)),
            driver=driver,
            is_simulated=self._told(lambda: bool(device.is_simulated)),
        )

    def _told(self, ask: Callable[[], T]) -> T | None:
        """Return an attribute of a board; None where its type does not have it."""
        try:
            with self.errors("asking for a board's identity"):
                return ask()
        except DeviceError:
            return None

    def devices(self) -> tuple[NiDevice, ...]:
        """Every board that the driver lists."""
        with self.errors("listing the devices"):
            return tuple(
                NiDevice(str(device.name), str(device.product_type))
                for device in self._system().devices
            )

    def has_output_clock(self, name: str) -> bool:
        """Return whether a board's analog outputs have a sample clock."""
        with self.errors("asking whether the outputs have a clock"):
            return bool(self._system().devices[name].ao_samp_clk_supported)

    def create_task(self, name: str) -> Any:
        """Make a nidaqmx.Task; DeviceReservedError when somebody holds one of that name.

        A server hands out a task by its name to whoever asks, silently: two programs would share
        one output. So an existing one is refused here.
        """
        from nidaqmx import Task
        from nidaqmx.errors import RpcError
        from nidaqmx.grpc_session_options import SessionInitializationBehavior as Behavior

        held = DeviceReservedError(
            f"the task '{name}' already exists on {self.where}: another labrig runs there, or one "
            "died; when none runs, `labrig safe` writes 0 V and frees it"
        )
        with self.errors(f"making the task '{name}'"):
            if self.is_local:
                return Task(name)
            try:
                task = Task(
                    name, grpc_options=self._options(name, Behavior.INITIALIZE_SERVER_SESSION)
                )
            except RpcError as fault:
                if _status(fault) in ("ALREADY_EXISTS", "FAILED_PRECONDITION"):
                    raise held from fault
                raise
            if task.number_of_channels:  # a server too old to know the behaviour has attached us
                raise held
            return task

    def attach_task(self, name: str) -> Any | None:
        """Return the task of that name that another process made; None when there is none."""
        from nidaqmx import Task
        from nidaqmx.errors import RpcError
        from nidaqmx.grpc_session_options import SessionInitializationBehavior as Behavior

        if self.is_local:
            return None
        with self.errors(f"attaching to the task '{name}'"):
            try:
                task = Task(
                    name, grpc_options=self._options(name, Behavior.ATTACH_TO_SERVER_SESSION)
                )
            except RpcError as fault:
                if _status(fault) in ("UNAVAILABLE", "DEADLINE_EXCEEDED", "CANCELLED"):
                    raise
                return None
            if task.number_of_channels:
                return task
            task.close()  # a server too old to know the behaviour has made an empty one
            return None

    def discard(self, task: Any) -> None:
        """Clear a task while another failure is on its way up, which is the one to report."""
        with suppress(DeviceError), self.errors("clearing a task"):
            task.close()

    def _system(self) -> Any:
        from nidaqmx.system import System

        return System.local() if self.is_local else System.remote(self._options("", 0))

    def _options(self, name: str, behaviour: int) -> Any:
        from nidaqmx import GrpcSessionOptions

        if self._channel is None:
            raise DeviceError(f"the connection to {self.where} is not open")
        return GrpcSessionOptions(self._channel, name, initialization_behavior=behaviour)

    def _device_names_or_none(self) -> Sequence[str] | None:
        """For an error text, which must not fail itself."""
        try:
            return [device.name for device in self.devices()]
        except DeviceError:
            return None


def _check_address(address: str) -> None:
    match = _HOST_PORT.match(address)
    if match is None or not 0 < int(match.group(2)) < 65536:
        raise DeviceNotFoundError(
            f'[ni] address = "{address}" is neither "local" nor "host:port" (port 1 to 65535)'
        )


def _serial(number: int | None) -> str:
    """Return a serial number as NI prints it on its boards: eight hexadecimal digits."""
    return f"{number:08X}" if number else ""


def _status(fault: Any) -> str:
    return str(getattr(fault.rpc_code, "name", fault.rpc_code))
