"""Boards on the virtual clock, and a witness that has seen every voltage there ever was."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from drivers.amplifier import Amplifier, SheetDrive
from drivers.boards.ni.analog_input import InputChannel, NiSignalInput
from drivers.boards.ni.analog_output import NiVoltageOutput
from drivers.boards.ni.connection import NiConnection
from drivers.interfaces import FloatArray, Prompt
from drivers.safe_shutdown import make_safe
from protocols import Devices, SafetyLimits, Scheduler, StopRequest
from protocols.execution.channels import current_channel, drive_channel, force_channel
from protocols.execution.events import Event
from sim_hardware.clock import VirtualClock
from sim_hardware.ni import NiDeviceServer

GAIN = 10.0
SAFE_BELOW_V = 0.05
HALF_STEP_V = GAIN * 20.2 / 2**17  # the board has 16 bits: a voltage is met as nearly as that
LIMITS = SafetyLimits(sheet_voltage_V=2.5, time_under_voltage_s=30.0)


class Witness:
    """A bench that is wired as the rig: ao0 drives an amplifier, ai2 reads it back."""

    def __init__(self) -> None:
        self.times_s = [0.0]
        self.volts = [0.0]  # at the sheet

    def write(self, device: str, channel: str, volts: float, when: float) -> None:
        """See `Bench.write`."""
        self.times_s.append(when)
        self.volts.append(GAIN * volts)

    def read(self, device: str, channel: str, times: FloatArray) -> FloatArray:
        """See `Bench.read`: the force follows the voltage, 1 mV per V."""
        at = np.searchsorted(self.times_s, times, side="right") - 1
        sheet_V = np.asarray(self.volts)[np.maximum(at, 0)]
        return sheet_V if channel == "ai2" else 1e-3 * sheet_V

    @property
    def largest_V(self) -> float:
        """Ever."""
        return max(map(abs, self.volts))


class Stage:
    """Goes where it is told."""

    def __init__(self) -> None:
        self.at_m: float | None = None

    def open(self) -> None:
        """Open already."""

    def move_to(self, position_m: float) -> bool:
        """At once."""
        self.at_m = position_m
        return True

    def position(self) -> float | None:
        """Where it is."""
        return self.at_m

    def close(self) -> None:
        """Nothing to do."""


class Person:
    """Does whatever is asked, until told to refuse."""

    def __init__(self) -> None:
        self.refuses = False

    def ask(self, prompt: Prompt) -> bool:
        """Done."""
        return not self.refuses


@dataclass
class WitnessedRig:
    """A scheduler on real drivers, simulated boards and the witness."""

    clock: VirtualClock = field(default_factory=VirtualClock)
    witness: Witness = field(default_factory=Witness)
    stop: StopRequest = field(default_factory=StopRequest)
    person: Person = field(default_factory=Person)
    events: list[Event] = field(default_factory=list)
    guarded: list[bool] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.server = NiDeviceServer(self.witness, self.clock)
        self.connection = NiConnection("simulated", channel=self.server.in_process_channel())
        amplifier = Amplifier(GAIN, LIMITS.sheet_voltage_V)
        board = NiVoltageOutput(self.connection, self.clock, "PCI6703/ao0", amplifier.limit_board_V)
        self.output = SheetDrive(board, amplifier)
        wired = (("force", "ai0", 0.05), ("current", "ai1", 0.5), ("drive", "ai2", 5.0))
        channels = [InputChannel(name, f"PCI6034E/{at}", volts) for name, at, volts in wired]
        self.signals = NiSignalInput(self.connection, self.clock, channels, 1000.0)
        self.connection.open()
        self.output.open()
        self.signals.open()

    def scheduler(self, emit: Any = None) -> Scheduler:
        """As labrig makes it."""
        devices = Devices(
            output=self.output,
            signals=self.signals,
            camera=None,
            stage=Stage(),
            operator=self.person,
            channels=(
                force_channel(range_V=0.05, conversion=lambda volts: volts / 0.15),
                current_channel(range_V=0.5, shunt_ohm=1.0),
                drive_channel(range_V=5.0),
            ),
        )
        return Scheduler(
            devices,
            self.clock,
            emit or self.events.append,
            self.stop,
            LIMITS,
            lambda: make_safe(self.output, self.signals, self.clock, "drive", SAFE_BELOW_V),
            on_energised=self.guarded.append,
            wall=lambda: "2026-01-01T00:00:00+00:00",
        )

    def at(self, when_s: float, act: Any) -> None:
        """Do something at a moment of virtual time."""

        def wait() -> None:
            self.clock.sleep_until(when_s)
            act()

        self.clock.start_thread(wait, "fault")
