"""The contract of a simulated serial device, and the check of one.

A file of this folder defines `SERIAL_DEVICE`, a `SimulatedSerial`. Its name is the `kind` of the
driver that speaks to the device, as rig.toml has it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

from drivers.interfaces import Clock
from sim_hardware.clock import VirtualClock


class SerialDevice(Protocol):
    """A device as a state machine: bytes in, bytes out, no waiting and no threads."""

    @property
    def baudrate(self) -> int:
        """Bits per second at which it listens and speaks."""

    def respond(self, data: bytes) -> bytes:
        """Return the answer to these bytes; they may hold a part of a command, or several."""

    def poll(self) -> bytes:
        """Return what it sends unasked; called again and again."""


class Arc(Protocol):
    """The arc on which the load cell stands."""

    @property
    def radius_mm(self) -> float:
        """Its radius."""


class SettingsWithArc(Protocol):
    """The settings of a world, as far as devices use them."""

    @property
    def arc(self) -> Arc:
        """The arc on which the load cell stands."""


class ForceWorld(Protocol):
    """A world whose force can be measured."""

    def true_force_N(self, when: float) -> float:
        """Return the force on the load cell at a clock time."""


class ArcWorld(Protocol):
    """A world whose load cell can be moved along an arc."""

    @property
    def settings(self) -> SettingsWithArc:
        """The world's settings."""

    def place(self, position_m: float | None, approach: Literal["up", "down"] = "up") -> None:
        """Put the load cell at this position on the arc, reached from below or above."""


class SerialWorld(ForceWorld, ArcWorld, Protocol):
    """The world that a device of a simulated rig acts on and measures."""


@dataclass(frozen=True)
class SimulatedSerial:
    """A kind of serial device."""

    role: str  # of the device at the rig: stage, meter; `serve` prints it with the address
    # Called for each line that is opened, with the seed of its noise; must not block, and starts
    # no thread.
    make: Callable[[SerialWorld, Clock, int], SerialDevice]


def faults(part: object) -> list[str]:
    """Return what is wrong with a device, a sentence each; one is made and asked."""
    if not isinstance(part, SimulatedSerial):
        return [f"SERIAL_DEVICE is of the type {type(part).__name__}, not a SimulatedSerial"]
    wrong = []
    if not part.role.isidentifier():
        wrong.append(f"role = {part.role!r} must be one word")
    device = part.make(_StillWorld(), VirtualClock(), 0)
    baudrate = getattr(device, "baudrate", None)
    if not isinstance(baudrate, int) or baudrate <= 0:
        wrong.append(f"baudrate = {baudrate!r} must be a whole number above 0")
    for name, arguments in (("respond", (b"",)), ("poll", ())):
        answer = getattr(device, name, lambda *_: None)(*arguments)
        if not isinstance(answer, bytes):
            wrong.append(f"{name} must return bytes, not {type(answer).__name__}")
    return wrong


@dataclass(frozen=True)
class _StillArc:
    radius_mm: float = 40.0


@dataclass(frozen=True)
class _StillSettings:
    arc: _StillArc = _StillArc()


@dataclass(frozen=True)
class _StillWorld:
    """A world in which nothing happens."""

    settings: _StillSettings = _StillSettings()

    def true_force_N(self, when: float) -> float:  # noqa: ARG002
        return 0.0

    def place(self, position_m: float | None, approach: Literal["up", "down"] = "up") -> None:
        """Leave the load cell where it is."""
