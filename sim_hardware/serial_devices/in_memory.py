"""A serial port without a port: for devices on a clock that is not the computer's."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import Self

from drivers.interfaces import Clock
from sim_hardware.serial_devices.contract import SerialDevice
from sim_hardware.serial_devices.wire import SerialFaults, Wire, garbled

_TICK_S = 1e-3  # how often a device is asked whether it has something to say
_BITS_PER_BYTE = 10  # 8N1


class InMemorySerial:
    """The part of pyserial's `Serial` that drivers use, with a simulated device behind it.

    Bytes take the time that the baud rate gives them; a reply begins when the command has arrived.
    Spoken to at another baud rate than its own the device understands nothing, and what it sends
    unasked is garbage.
    """

    def __init__(
        self,
        device: SerialDevice,
        clock: Clock,
        *,
        port: str = "simulated",
        baudrate: int | None = None,
        timeout: float | None = None,
        write_timeout: float | None = None,
        faults: SerialFaults | None = None,
    ) -> None:
        self._wire = Wire(device, faults)
        self._clock = clock
        self.port = port
        self.baudrate = device.baudrate if baudrate is None else baudrate
        self.timeout = timeout
        self.write_timeout = write_timeout
        self.is_open = True
        self._coming: deque[tuple[float, bytes]] = deque()  # when the last byte is there, bytes
        self._arrived = bytearray()
        self._polled_s = clock.now()
        self._spoken = 0

    @property
    def faults(self) -> SerialFaults:
        """The faults of the cable."""
        return self._wire.faults

    @property
    def in_waiting(self) -> int:
        """Bytes that can be read without waiting."""
        self._receive()
        return len(self._arrived)

    def write(self, data: bytes) -> int:
        """Send bytes; takes the time they need on the wire."""
        self._check()
        self._receive()
        self._clock.sleep_until(self._clock.now() + self._duration(data))
        if self._rates_match:
            self._hear(self._wire.respond(bytes(data)), self._clock.now())
        return len(data)

    def read(self, size: int = 1) -> bytes:
        """Up to `size` bytes, fewer when the time-out is over."""
        return self._read_when(lambda: size if len(self._arrived) >= size else 0, size)

    def read_until(self, expected: bytes = b"\n", size: int | None = None) -> bytes:
        """Up to and with `expected`, or `size` bytes, or what came until the time-out."""

        def complete() -> int:
            found = self._arrived.find(expected)
            end = found + len(expected) if found >= 0 else 0
            if size is not None and (end or len(self._arrived)) >= size:
                return size
            return end

        return self._read_when(complete, size)

    def reset_input_buffer(self) -> None:
        """Forget what has arrived."""
        self._receive()
        self._arrived.clear()

    def reset_output_buffer(self) -> None:
        """Nothing waits to be sent."""
        self._check()

    def flush(self) -> None:
        """Everything is sent when `write` returns."""
        self._check()

    def close(self) -> None:
        """Close the port. May be called twice."""
        self.is_open = False

    def open(self) -> None:
        """Open it again."""
        self.is_open = True
        self._check()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self.close()

    # ------------------------------------------------------------------------------------ within

    @property
    def _rates_match(self) -> bool:
        return self.baudrate == self._wire.device.baudrate

    def _duration(self, data: bytes) -> float:
        return len(data) * _BITS_PER_BYTE / self.baudrate

    def _check(self) -> None:
        import serial

        if not self.is_open:
            raise serial.PortNotOpenError
        if self.faults.unplugged:
            raise serial.SerialException(f"{self.port}: device disconnected")

    def _hear(self, sent: bytes, since_s: float) -> None:
        """Queue what the device sends from this time on, or after what it sent before."""
        if not sent:
            return
        if not self._rates_match:
            self._spoken += 1
            sent = garbled(sent, self._spoken)
        began_s = max(since_s, self._coming[-1][0]) if self._coming else since_s
        self._coming.append((began_s + self._duration(sent), sent))

    def _receive(self) -> None:
        self._check()
        self._hear(self._wire.poll(), self._polled_s)
        self._polled_s = self._clock.now()
        # A clock may wake a sleeper a rounding error early.
        while self._coming and self._coming[0][0] <= self._clock.now() + 1e-9:
            self._arrived += self._coming.popleft()[1]

    def _read_when(self, complete: Callable[[], int], size: int | None) -> bytes:
        start = self._clock.now()
        end = math.inf if self.timeout is None else start + self.timeout
        while True:
            self._receive()
            count = complete()
            now = self._clock.now()
            if count or now >= end:
                break
            wake = min(end, now + _TICK_S)
            self._clock.sleep_until(min(wake, self._coming[0][0]) if self._coming else wake)
        count = count or (len(self._arrived) if size is None else size)
        data = bytes(self._arrived[:count])
        del self._arrived[:count]
        return data
