"""NI boards for the conformance tests: simulated two ways, and real ones with --rig."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from drivers.boards.ni.analog_input import InputChannel, NiSignalInput
from drivers.boards.ni.analog_output import NiVoltageOutput
from drivers.boards.ni.connection import NiConnection
from drivers.interfaces import Clock, RealClock

DRIVE, FORCE, CURRENT, READ_BACK = "PCI6703/ao0", "PCI6034E/ai0", "PCI6034E/ai1", "PCI6034E/ai2"


@dataclass
class NiRig:
    """A connection to boards whose drive output is wired to the read-back input."""

    connection: NiConnection
    clock: Clock
    server: Any = None  # the simulated one, for its faults
    drive: str = DRIVE
    inputs: tuple[InputChannel, ...] = (
        InputChannel("force", FORCE, 0.04, "differential"),
        InputChannel("current", CURRENT, 0.3),
        InputChannel("drive", READ_BACK, 4.0),
    )
    volts_per_volt: float = 1.0  # read back per board volt: the gain of the amplifier, if any
    made: list[Any] = field(default_factory=list)

    def output(self, limit_V: float = 0.25, **kwargs: Any) -> NiVoltageOutput:
        """The drive output, not open yet."""
        output = NiVoltageOutput(self.connection, self.clock, self.drive, limit_V, **kwargs)
        self.made.append(output)
        return output

    def signals(self, rate_hz: float = 1000.0, **kwargs: Any) -> NiSignalInput:
        """The three inputs, not open yet."""
        signals = NiSignalInput(self.connection, self.clock, self.inputs, rate_hz, **kwargs)
        self.made.append(signals)
        return signals

    def wait(self, seconds: float) -> None:
        self.clock.sleep_until(self.clock.now() + seconds)

    def end(self) -> None:
        """Leave no task behind, whatever a test did to the server."""
        if self.server is not None:
            self.server.faults.hang.clear()
            self.server.faults.refuse.clear()
        for device in self.made:
            with suppress(Exception):  # the test has said what it found
                device.close()
        self.connection.close()


def in_process() -> NiRig:
    from sim_hardware.clock import VirtualClock
    from sim_hardware.ni import LoopbackWires, NiDeviceServer

    clock = VirtualClock()
    server = NiDeviceServer(LoopbackWires({"ao0": "ai2"}), clock)
    connection = NiConnection("simulated", server.in_process_channel())
    return NiRig(connection, clock, server)


def over_tcp() -> NiRig:
    from sim_hardware.ni import LoopbackWires, NiDeviceServer

    clock = RealClock()
    server = NiDeviceServer(LoopbackWires({"ao0": "ai2"}), clock)
    return NiRig(NiConnection(f"127.0.0.1:{server.listen(0)}"), clock, server)


def real(path: Path) -> NiRig:
    rig = tomllib.loads(path.read_text())
    ni = rig["ni"]
    inputs = (
        InputChannel("force", ni["force"], 0.04, "differential"),
        InputChannel("current", ni["current"], 0.3),
        InputChannel("drive", ni["drive_readback"], 4.0),
    )
    gain = float(rig["amplifier"]["gain"])
    connection = NiConnection(ni["address"])
    return NiRig(connection, RealClock(), None, ni["drive"], inputs, gain)


@pytest.fixture(
    params=["in process", "over TCP", pytest.param("real", marks=pytest.mark.real_hardware)]
)
def ni_rig(request: pytest.FixtureRequest) -> Iterator[NiRig]:
    """Boards of every kind there is."""
    if request.param == "in process":
        rig = in_process()
    elif request.param == "over TCP":
        rig = over_tcp()
    else:
        rig = real(request.getfixturevalue("rig_file"))
    yield from _opened(rig)


@pytest.fixture
def simulated_ni() -> Iterator[NiRig]:
    """Simulated boards in this process, on the virtual clock."""
    yield from _opened(in_process())


@pytest.fixture
def tcp_ni() -> Iterator[NiRig]:
    """Simulated boards behind a port, on the real clock."""
    yield from _opened(over_tcp())


def _opened(rig: NiRig) -> Iterator[NiRig]:
    rig.connection.open()
    try:
        yield rig
    finally:
        rig.end()
        if rig.server is not None:
            rig.server.stop()
