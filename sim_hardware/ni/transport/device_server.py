"""The simulated NI gRPC Device Server: boards of a rig, reached by TCP or in this process."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

import grpc

from drivers.interfaces import Clock
from sim_hardware.default_boards import default_boards
from sim_hardware.ni.boards import board_model
from sim_hardware.ni.faults import Faults
from sim_hardware.ni.signals.digital_lines import Lines
from sim_hardware.ni.tasks.engine import Engine
from sim_hardware.ni.transport.in_process import InProcessChannel
from sim_hardware.ni.transport.server import TcpServer
from sim_hardware.ni.transport.service import methods
from sim_hardware.plugins import UnknownPartError
from sim_hardware.simulated_rig import AnalogSide

_DEVICE_NAME = re.compile(r"^[A-Za-z0-9_-]+$")


class NiDeviceServer:
    """Simulated boards behind NI's public protocol.

    `faults` may be changed at any time; `lines` holds the digital lines' levels and edges.
    """

    def __init__(
        self,
        rig: AnalogSide,
        clock: Clock,
        devices: Mapping[str, str] | None = None,
        driver_version: str = "26.0",
        *,
        strict_ownership: bool = False,
        seed: int | None = 0,
        clock_error_ppm: float = 0.0,
        is_wired: Callable[[str, str], bool] | None = None,
        edges_hz: Mapping[str, float] | None = None,
    ) -> None:
        """`devices` maps names to product types (None: those of the shipped world).

        ValueError for a name that is none, or a product type that is not simulated.

        `seed` is that of the converters' noise; None: they have none (a recording has its own).
        `clock_error_ppm`: how much faster the boards' oscillators are than `clock`.
        `is_wired`: inputs (device, channel) that are not show what NI's simulated devices do: a
        sine between the channel's limits; and lines that nobody writes count.
        `edges_hz`: square waves that come to PFI terminals, such as {"Dev1/PFI0": 2.0}.
        """
        self.faults = Faults()
        self._strict = strict_ownership
        boards = _known(devices or default_boards())
        self.device_names = tuple(boards)
        self._engine = Engine(
            rig,
            clock,
            boards,
            driver_version=parse_version(driver_version),
            faults=self.faults,
            seed=seed,
            strict_ownership=strict_ownership,
            clock_error_ppm=clock_error_ppm,
            is_wired=is_wired,
            edges_hz=edges_hz,
        )
        self._methods = methods()
        self._tcp: TcpServer | None = None

    @property
    def lines(self) -> Lines:
        """The boards' digital lines."""
        return self._engine.lines

    def in_process_channel(self) -> grpc.Channel:
        """Open a connection without a socket; each is a client of its own."""
        return InProcessChannel(self._engine, self._methods)

    def listen(self, port: int = 0) -> int:
        """Answer on a port of this computer (0: a free one) and return it. PortTakenError."""
        if self._engine.is_virtual:
            raise RuntimeError("a server on a virtual clock is reached by in_process_channel only")
        if self._tcp is not None:
            raise RuntimeError(f"the server listens on port {self._tcp.port} already")
        self._tcp = TcpServer(self._engine, self._methods, port, watch_clients=self._strict)
        return self._tcp.port

    def stop(self) -> None:
        """Cut every TCP connection. Tasks stay as they are. May be called twice."""
        if self._tcp is not None:
            self._tcp.stop()
            self._tcp = None


def parse_version(text: str) -> tuple[int, int, int]:
    """`19.6` or `26.0.1` as three numbers; ValueError otherwise."""
    parts = text.split(".")
    if not 1 <= len(parts) <= 3 or not all(part.isdecimal() for part in parts):
        raise ValueError(f"'{text}' is not a driver version such as 19.6 or 26.0")
    major, minor, update = (*map(int, parts), 0, 0)[:3]
    return major, minor, update


def _known(devices: Mapping[str, str]) -> Mapping[str, str]:
    for name, product_type in devices.items():
        if not _DEVICE_NAME.match(name):
            raise ValueError(f"'{name}' is not a device's name: letters, digits, - and _")
        try:
            board_model(product_type)
        except UnknownPartError as fault:
            raise ValueError(f"{name}: {fault}") from None
    return devices
