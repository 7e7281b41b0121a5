"""The cable between a simulated serial device and its port, and its faults."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass

import numpy as np

from sim_hardware.serial_devices.contract import SerialDevice


@dataclass
class SerialFaults:
    """The faults of the cable, by reply; may be changed while the port is open.

    Replies are numbered from 0; any container of numbers will do: a set, a range.
    """

    garbage: Container[int] = ()
    """Arrive as other bytes, as at a wrong baud rate."""
    half_line: Container[int] = ()
    """Break off in the middle."""
    silent: Container[int] = ()
    """Never arrive."""
    unplugged: bool = False
    """The port is gone."""


def garbled(data: bytes, seed: int) -> bytes:
    """As many bytes, at random."""
    return np.random.default_rng(seed).bytes(len(data))


class Wire:
    """A device with the faults of its cable."""

    def __init__(self, device: SerialDevice, faults: SerialFaults | None = None) -> None:
        self.device = device
        self.faults = faults if faults is not None else SerialFaults()
        self._replies = 0

    def respond(self, data: bytes) -> bytes:
        """See `SerialDevice.respond`."""
        reply = self.device.respond(data)
        if not reply:
            return b""
        number, self._replies = self._replies, self._replies + 1
        if number in self.faults.silent:
            return b""
        if number in self.faults.half_line:
            return reply[: len(reply) // 2]
        return garbled(reply, number) if number in self.faults.garbage else reply

    def poll(self) -> bytes:
        """See `SerialDevice.poll`."""
        return self.device.poll()
