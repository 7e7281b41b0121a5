"""Simulated LabJacks whose output is wired to their read-back, in this process or over TCP."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from drivers.boards import BOARD_FAMILIES
from drivers.boards.contract import DRIVE
from drivers.boards.labjack.family import LabJackBoards
from drivers.boards.labjack.settings import LabJackSettings
from drivers.interfaces import Clock, RealClock
from sim_hardware.clock import VirtualClock
from sim_hardware.labjack import SIMULATED_MODELS, LabJackServer, SimulatedLabJack
from sim_hardware.labjack.server import InProcess
from sim_hardware.ni import LoopbackWires

FAMILY = BOARD_FAMILIES.get("labjack")
LIMIT_V = 0.25
T4 = {"model": "T4", "current": "AIN1", "drive_readback": "AIN2"}
T8 = {"model": "T8", "current": "AIN1", "drive_readback": "AIN2"}
STAGE = {"drive": "DAC0", "zero_V": 2.5, "stage_gain": 4.0}
# each product type, with the settings that fit it
MODELS: dict[str, dict[str, Any]] = {
    "T7": {},
    "T7 DAC0": STAGE,
    "T4": T4,
    "T4 DAC0": T4 | STAGE,
    "T8": T8,
    "T8 DAC0": T8 | STAGE,
}


class LabJackRig:
    """A device, and the driver's side of it."""

    def __init__(self, clock: Clock, product_type: str = "T7", **settings: Any) -> None:
        self.clock = clock
        self.bench = LoopbackWires({"ao0": "ai2"})
        self.device = SimulatedLabJack(self.bench, clock, SIMULATED_MODELS[product_type])
        self.server: LabJackServer | None = None
        self.made: list[LabJackBoards] = []
        self.settings = LabJackSettings(**(MODELS[product_type] | settings))
        if isinstance(clock, RealClock):
            self.server = LabJackServer(self.device)
            address = f"127.0.0.1:{self.server.port}"
            self.settings = replace(self.settings, address=address)

    def boards(self) -> LabJackBoards:
        """A connection, not open yet."""
        transport = None if self.server is not None else lambda: InProcess(self.device)
        self.made.append(FAMILY.connect(self.settings, self.clock, transport))
        return self.made[-1]

    def inputs(self):
        """Force, current and drive."""
        return FAMILY.inputs(self.settings)

    def place(self, line: str | None = None) -> dict[str, Any]:
        """Where its output is."""
        return FAMILY.output_place(self.settings, LIMIT_V, 0.05, line)

    def output_V(self) -> float:
        """What is put out to the amplifier now."""
        return float(self.bench.read("", "ai2", [self.clock.now()])[0])

    def read_back_V(self) -> float:
        """What the device's inputs measure of it, through another connection."""
        boards = self.boards()
        boards.open()
        signals = boards.signal_input(self.inputs())
        signals.open()
        try:
            row = list(signals.channels).index(DRIVE)
            return float(signals.measure(0.02)[row].mean())
        finally:
            signals.close()
            boards.close()

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        self.clock.sleep_until(self.clock.now() + seconds)


def virtual(product_type: str = "T7", **settings: Any) -> LabJackRig:
    """In this process, on the virtual clock."""
    return LabJackRig(VirtualClock(), product_type, **settings)


@contextmanager
def over_tcp(product_type: str = "T7", **settings: Any) -> Iterator[LabJackRig]:
    """Behind a port, on the real clock."""
    rig = LabJackRig(RealClock(), product_type, **settings)
    try:
        yield rig
    finally:
        for boards in rig.made:
            boards.close()
        assert rig.server is not None
        rig.server.stop()
