"""The simulated NI gRPC Device Server: boards on a bench, reached by TCP or in this process."""

from __future__ import annotations

from collections.abc import Mapping

import grpc

from drivers.interfaces import Clock
from sim_hardware.ni.boards.boards import BOARDS
from sim_hardware.ni.faults import Faults
from sim_hardware.ni.signals.lines import Lines
from sim_hardware.ni.tasks.engine import Engine
from sim_hardware.ni.transport.channel import InProcessChannel
from sim_hardware.ni.transport.server import TcpServer
from sim_hardware.ni.transport.service import methods
from sim_hardware.simulated_rig import AnalogSide

DEFAULT_DEVICES = {"PCI6703": "PCI-6703", "PCI6034E": "PCI-6034E"}


class NiDeviceServer:
    """Simulated boards behind NI's public protocol.

    `faults` may be changed at any time; `lines` tells the digital lines' levels and edges.
    """

    def __init__(
        self,
        bench: AnalogSide,
        clock: Clock,
        devices: Mapping[str, str] | None = None,
        driver_version: str = "26.0",
        *,
        strict_ownership: bool = False,
        seed: int | None = 0,
    ) -> None:
        """`devices` maps names to product types; ValueError for one that is not simulated.

        `seed` is that of the converters' noise; None: they have none (a recording has its own).
        """
        self.faults = Faults()
        self._strict = strict_ownership
        boards = _known(devices or DEFAULT_DEVICES)
        self.device_names = tuple(boards)
        self._engine = Engine(
            bench,
            clock,
            boards,
            parse_version(driver_version),
            self.faults,
            seed,
            strict_ownership=strict_ownership,
        )
        self._methods = methods()
        self._tcp: TcpServer | None = None

    @property
    def lines(self) -> Lines:
        """The boards' digital lines."""
        return self._engine.lines

    def in_process_channel(self) -> grpc.Channel:
        """A connection without a socket; each is a client of its own."""
        return InProcessChannel(self._engine, self._methods)

    def listen(self, port: int = 0) -> int:
        """Answer on a port of this computer (0: a free one); tells which. PortTakenError."""
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
    for name, model in devices.items():
        if model not in BOARDS:
            raise ValueError(
                f"{name}: there is no simulated board '{model}'; there are {', '.join(BOARDS)}"
            )
    return devices
