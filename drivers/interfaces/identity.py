"""What a device reports of itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable


@dataclass(frozen=True, kw_only=True)
class DeviceIdentity:
    """What a device, or its driver, reports of itself. Empty and None: not known."""

    name: str = ""  # as the system or rig.toml calls it, such as PCI6703
    maker: str = ""
    product: str = ""  # product or model, such as PCI-6703
    serial: str = ""
    driver: str = ""  # the driver software and its version, such as NI-DAQmx 26.0.0
    is_simulated: bool | None = None


@runtime_checkable
class Identified(Protocol):
    """A device, or a connection to several, that reports what it is; boards and parts may do so."""

    def identities(self) -> Sequence[DeviceIdentity]:
        """Return what is known of each device. Open; blocks for 1 s at most. Raises DeviceError."""
