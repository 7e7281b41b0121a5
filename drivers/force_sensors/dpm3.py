"""The DPM-3 panel meter on a serial line: another way to read a load cell.

8N1; commands end in CR and begin with `*`, the address (0: any meter) and the command. A reply is
`+999.99` CR: sign first, the point always there, perhaps an LF, perhaps an alarm letter A to H.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

from drivers.force_sensors.contract import ForceSensorKind, Transport
from drivers.interfaces import (
    Clock,
    DeviceError,
    DeviceIdentity,
    DeviceTimeoutError,
    ForceSensor,
    OverloadError,
)
from drivers.serial_port import SerialLine

GRAM_FORCE_N = 9.80665e-3
BAUD_RATES = (300, 600, 1200, 2400, 4800, 9600, 19200)
_REPLY = re.compile(rb"^\n?([+-](?:\d{1,9}\.\d{0,9}|\.\d{1,9}))([A-H]?)\n?$")
_ADDRESSES = "0123456789ABCDEFGHIJKLMNOPQRSTUV"
_OVERLOADED = ("E", "F", "G", "H")  # A to D: alarms neither, first, second, both; E to H: and this
_SHOWN = 60  # characters of a reply in an error
_LONGEST_REPLY = 12  # characters, for the time-out at a low baud rate


@dataclass(frozen=True, kw_only=True)
class Dpm3Settings:
    """A DPM-3 panel meter on a serial line, which reads the load cell in the board's place."""

    port: str = field(
        metadata={"description": "serial port, such as COM4 or /dev/ttyUSB1, or simulated"}
    )
    address: int = field(
        default=0, metadata={"ge": 0, "le": 31, "description": "of the meter; 0: any meter"}
    )
    baudrate: Literal[300, 600, 1200, 2400, 4800, 9600, 19200] = field(
        default=9600, metadata={"description": "as set at the meter"}
    )
    newtons_per_unit: float = field(
        default=GRAM_FORCE_N,
        metadata={"gt": 0, "unit": "N", "description": "what the meter displays as 1 (gram-force)"},
    )
    range_N: float = field(
        default=0.98,
        metadata={"gt": 0, "le": 1000, "unit": "N", "description": "largest force it can display"},
    )


class Dpm3Meter:
    """A `ForceSensor`. `newtons_per_unit`: of the unit that the meter displays (gram-force)."""

    def __init__(
        self,
        port: str,
        newtons_per_unit: float = GRAM_FORCE_N,
        address: int = 0,
        baudrate: int = 9600,
        serial_factory: Callable[..., Any] | None = None,
        range_N: float = 0.98,
    ) -> None:
        if baudrate not in BAUD_RATES:
            rates = ", ".join(map(str, BAUD_RATES))
            raise DeviceError(f"DPM-3 meter on {port}: baud rate {baudrate} is none of {rates}")
        wire_s = 2 * _LONGEST_REPLY * 10 / baudrate
        self._line = SerialLine("DPM-3 meter", port, baudrate, 0.5 + wire_s, serial_factory)
        if not 0 <= address < len(_ADDRESSES):
            raise DeviceError(f"DPM-3 meter on {port}: address {address} is not one of 0 to 31")
        self._address = _ADDRESSES[address]
        self._newtons_per_unit = newtons_per_unit
        self.range_N = range_N  # see `ForceSensor.range_N`
        self.alarm = ""  # the alarm letter of the last reply, if any

    def open(self) -> None:
        """Take the port and end continuous output, which would mix with replies."""
        self._line.open()
        try:
            self._send("A1")
            self._first_reply()
        except DeviceError:
            self._line.close()
            raise

    def read_force(self) -> float:
        """See `ForceSensor.read_force`."""
        self._line.drop_input()
        self._send("B1")
        return self._parse(self._line.read_line(b"\r")) * self._newtons_per_unit

    def tare(self) -> None:
        """See `ForceSensor.tare`."""
        self._send("CA")

    def untare(self) -> None:
        """Take the tare back."""
        self._send("CB")

    def identities(self) -> tuple[DeviceIdentity, ...]:
        """See `Identified.identities`; its protocol has no command for its serial number."""
        return (DeviceIdentity(name=self._line.name, product="DPM-3"),)

    def close(self) -> None:
        """See `ForceSensor.close`."""
        self._line.close()

    def _first_reply(self) -> None:
        """Read once more where the rest of an unasked reading came first."""
        try:
            self.read_force()
        except DeviceTimeoutError:
            raise
        except OverloadError:
            pass  # it answers; the load is for whoever reads it
        except DeviceError:
            self.read_force()

    def _send(self, command: str) -> None:
        self._line.write(f"*{self._address}{command}\r".encode("ascii"))

    def _parse(self, line: bytes) -> float:
        if not line:
            raise DeviceTimeoutError(
                f"{self._line.name} did not answer; check that it is on, its baud rate and address"
            )
        match = _REPLY.match(line.removesuffix(b"\r"))
        if match is None or not line.endswith(b"\r"):
            raise DeviceError(
                f"{self._line.name} sent {line[:_SHOWN]!r} where a reading such as +999.99 was "
                "expected; check baud rate and wiring"
            )
        self.alarm = match.group(2).decode("ascii")
        if self.alarm in _OVERLOADED:
            raise OverloadError(
                f"{self._line.name} is beyond its range at {line.strip().decode('ascii')}: unload "
                "the cell, or set the meter to a wider range"
            )
        return float(match.group(1))


def _make(settings: Dpm3Settings, _clock: Clock, transport: Transport | None) -> ForceSensor:
    return Dpm3Meter(
        settings.port,
        settings.newtons_per_unit,
        settings.address,
        settings.baudrate,
        transport,
        settings.range_N,
    )


FORCE_SENSOR = ForceSensorKind(
    kind="dpm3",
    help="a DPM-3 panel meter on a serial port, in the place of the board's input `force`",
    settings=Dpm3Settings,
    make=_make,
)
