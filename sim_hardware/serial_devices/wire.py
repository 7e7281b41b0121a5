"""The cable between a simulated serial device and its port, and its faults."""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import dataclass
from pathlib import Path
from traceback import walk_tb

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


class WrongAnswerError(Exception):
    """A simulated device has answered with something else than bytes."""


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
        reply = self._asked(self.device.respond, data)
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
        return self._asked(self.device.poll)

    def why(self, fault: Exception) -> str:
        """Return what its code raised, on one line and with the place."""
        if isinstance(fault, WrongAnswerError):
            return str(fault)
        frame, line = list(walk_tb(fault.__traceback__))[-1]
        place = f"{Path(frame.f_code.co_filename).name}, line {line}"
        text = " ".join(f"{type(fault).__name__}: {fault}".split())
        return f"the simulated device {type(self.device).__name__} raised {text} ({place})"

    def _asked(self, method: Callable[..., object], *arguments: bytes) -> bytes:
        """Return what the device says; its code may be another distribution's."""
        answer = method(*arguments)
        if not isinstance(answer, bytes | bytearray):
            raise WrongAnswerError(
                f"the simulated device {type(self.device).__name__} returned "
                f"{type(answer).__name__} from {method.__name__}; it must return bytes"
            )
        return bytes(answer)
