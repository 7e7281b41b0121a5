"""The table [ni] of rig.toml."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from drivers.boards.ni.analog_input import INPUT_TASK
from drivers.boards.ni.analog_output import OUTPUT_TASK

_CHANNEL = re.compile(r"^[^/\s]+/(ai|ao|port\d+/line)\d+$")
_LINE = re.compile(r"^[^/\s]+/port\d+/line\d+$")
_HOST_PORT = re.compile(r"^[^:\s]+:\d{1,5}$")


def check_channel(value: str) -> None:
    """Raise ValueError unless a channel can have this name."""
    if not _CHANNEL.match(value):
        raise ValueError("must be a device and a channel, such as PCI6034E/ai0")


def check_line(value: str) -> str:
    """Return a line's name as all its spellings have it; ValueError where it can be none."""
    if not _LINE.match(value):
        raise ValueError("must be a digital line, such as PCI6703/port0/line0")
    return value.lower()


def check_address(value: str) -> None:
    """Raise ValueError unless boards can have this address."""
    if value != "local" and not _HOST_PORT.match(value):
        raise ValueError('must be "local", "simulated" or host:port of an NI gRPC Device Server')


def _channel(default: str, description: str) -> str:
    facts = {"check": check_channel, "description": description}
    channel: str = field(default=default, metadata=facts)
    return channel


def _range(default: float, description: str) -> float:
    facts = {"gt": 0, "le": 10.0, "unit": "V", "description": description}
    largest: float = field(default=default, metadata=facts)
    return largest


def _task(default: str, does: str) -> str:
    name: str = field(default=default, metadata={"description": f"of the task that {does}"})
    return name


@dataclass(frozen=True, kw_only=True)
class TaskNames:
    """Names of the NI tasks, by which the guard and `labrig safe` find them."""

    output: str = _task(OUTPUT_TASK, "writes the sheet's voltage")
    input: str = _task(INPUT_TASK, "reads force, current and voltage")
    interlock: str = _task("labrig-interlock", "toggles the interlock's line")
    trigger: str = _task("labrig-trigger", "triggers the camera")


@dataclass(frozen=True, kw_only=True)
class InputRanges:
    """Largest voltage expected at each input; the board rounds it up to a range it has."""

    force: float = _range(0.05, "V, either sign, of the load cell")
    current: float = _range(0.5, "V, either sign, across the shunt")
    drive: float = _range(5.0, "V, either sign, at the sheet")


@dataclass(frozen=True, kw_only=True)
class NiSettings:
    """The National Instruments boards."""

    address: str = field(
        default="local",
        metadata={
            "check": check_address,
            "description": "local driver, host:port of an NI gRPC Device Server, or simulated",
        },
    )
    drive: str = _channel("PCI6703/ao0", "output that drives the amplifier")
    force: str = _channel("PCI6034E/ai0", "input of the load cell, differential")
    current: str = _channel("PCI6034E/ai1", "input of the current shunt")
    drive_readback: str = _channel("PCI6034E/ai2", "input of the sheet voltage")
    sample_rate_hz: float = field(
        default=1000.0,
        metadata={"ge": 100.0, "le": 66_000.0, "unit": "1/s", "description": "of each channel"},
    )
    timed_output: bool = field(
        default=True,
        metadata={
            "description": "edges by the clock of the inputs, where one board has both and can"
        },
    )
    task_names: TaskNames = field(default=TaskNames(), metadata={"description": "of the NI tasks"})
    ranges_V: InputRanges = field(default=InputRanges(), metadata={"description": "of the inputs"})
