"""Terminals of a board: what a trigger or a sample clock may come from."""

from __future__ import annotations

from dataclasses import dataclass

from sim_hardware.ni.devices import DeviceRegistry
from sim_hardware.ni.errors import Code, StatusError
from sim_hardware.ni.names import split_device

ONBOARD = ("", "OnboardClock")
START, CLOCK = "StartTrigger", "SampleClock"
_SIDES = ("ai", "ao")
_PFI_LINES = 16


@dataclass(frozen=True)
class Terminal:
    """A terminal of a device.

    `side` is the side of the board (ai, ao) whose task drives it; None: an outside signal, of which
    no simulated one comes.
    """

    device: str
    side: str | None
    signal: str


def terminal(devices: DeviceRegistry, name: str) -> Terminal:
    """Return the terminal of a name such as /Dev1/ai/StartTrigger; -200254 for none."""
    device_name, rest = split_device(name)
    device = devices.find(device_name) if rest else None
    side, _, signal = rest.partition("/")
    if device is not None and side.lower() in _SIDES:
        for known in (START, CLOCK):
            if signal.lower() == known.lower():
                return Terminal(device.name, side.lower(), known)
    if device is not None and rest.upper() in {f"PFI{i}" for i in range(_PFI_LINES)}:
        return Terminal(device.name, None, rest.upper())
    raise StatusError(Code.INVALID_TERMINAL, f"Source Terminal: {name}")
