"""A serial line with errors in words, on pyserial or on anything with its `Serial` interface."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from drivers.interfaces import DeviceError, DeviceNotFoundError


class SerialLine:
    """One device on one port. Reads end after `timeout_s` with what has come."""

    def __init__(
        self,
        device: str,
        port: str,
        baudrate: int,
        timeout_s: float,
        serial_factory: Callable[..., Any] | None = None,
    ) -> None:
        self.name = f"the {device} on {port}"
        self._port = port
        self._baudrate = baudrate
        self._timeout_s = timeout_s
        self._factory = serial_factory
        self._serial: Any = None

    def open(self) -> None:
        """Take the port; one that is open already is left as it is."""
        if self._serial is not None:
            return
        factory = self._factory or _pyserial
        try:
            self._serial = factory(
                self._port,
                baudrate=self._baudrate,
                timeout=self._timeout_s,
                write_timeout=self._timeout_s,
            )
        except (OSError, ValueError) as fault:  # pyserial's errors are OSErrors
            there = ", ".join(_ports()) or "none"
            raise DeviceNotFoundError(
                f"{self.name}: the port cannot be opened ({fault}); ports found: {there}"
            ) from fault

    def write(self, data: bytes) -> None:
        """Send all of `data`."""
        self._guarded("writing", lambda serial: serial.write(data))

    def read_line(self, end: bytes) -> bytes:
        """Up to and with `end`; shorter, perhaps empty, when the time is over."""
        line: bytes = self._guarded("reading", lambda serial: serial.read_until(end))
        return line

    def drop_input(self) -> None:
        """Forget what has come so far."""
        self._guarded("reading", lambda serial: serial.reset_input_buffer())

    def close(self) -> None:
        """Let go of the port. May be called twice."""
        serial, self._serial = self._serial, None
        if serial is not None:
            serial.close()

    def _guarded(self, doing: str, action: Callable[[Any], Any]) -> Any:
        if self._serial is None:
            raise DeviceError(f"{self.name} is not open")
        try:
            return action(self._serial)
        except (OSError, TypeError) as fault:  # TypeError: pyserial on a port that was pulled
            raise DeviceError(
                f"{doing} failed: {self.name} is gone ({fault}); check its cable"
            ) from fault


def _pyserial(port: str, **settings: Any) -> Any:
    import serial

    return serial.serial_for_url(port, **settings)


def _ports() -> list[str]:
    from serial.tools import list_ports

    return [str(port.device) for port in list_ports.comports()]
