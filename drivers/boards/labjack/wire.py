"""One Modbus TCP connection to a T-series device: requests, answers, and what can go wrong."""

from __future__ import annotations

import re
import socket
import struct
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import NamedTuple, Protocol

from drivers.boards.labjack.errors import refused
from drivers.boards.labjack.registers import LAST_ERROR, Register
from drivers.interfaces import Clock, DeviceError, DeviceNotFoundError, DeviceTimeoutError

PORT = 502
ANSWER_S = 1.0  # a healthy one answers in 1 to 4 ms
HURRIED_S = 0.5  # one that has just let a request run out of time
CONNECT_S = 1.0
_TURN_S = ANSWER_S + CONNECT_S  # a request of another thread takes no longer
_LOOK_S = 1e-3
READ, WRITE, FEEDBACK = 3, 16, 76
MOST_REGISTERS = 124  # in one read
_HEAD = struct.Struct(">HHHB")  # transaction, protocol 0, length, unit
_UNIT = 1
_ADDRESS = re.compile(r"^(\[[0-9A-Fa-f:.]+\]|[^\s:/\[\]]+)(?::(\d{1,5}))?$")


class Transport(Protocol):
    """What carries requests: a socket, or the simulator in this process."""

    def exchange(self, request: bytes, answer_s: float) -> bytes:
        """Send a whole request and return its whole answer, within so long. Raises OSError."""

    def close(self) -> None:
        """End the connection. May be called twice."""


class Write(NamedTuple):
    """A value for a register."""

    register: Register
    value: float


def host_and_port(address: str) -> tuple[str, int]:
    """Return host and port of "host" or "host:port"; ValueError otherwise."""
    match = _ADDRESS.match(address)
    port = int(match[2] or PORT) if match else 0
    if match is None or not 0 < port < 65536:
        raise ValueError('must be the device\'s address, such as "192.0.2.7", or "simulated"')
    return match[1].strip("[]"), port


class SocketTransport:
    """A TCP connection."""

    def __init__(self, host: str, port: int) -> None:
        """Connect. Raises OSError."""
        self._socket = socket.create_connection((host, port), CONNECT_S)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def exchange(self, request: bytes, answer_s: float) -> bytes:
        """See `Transport.exchange`."""
        until_s = time.monotonic() + answer_s
        self._socket.settimeout(answer_s)
        self._socket.sendall(request)
        head = self._exactly(_HEAD.size, until_s)
        length = _HEAD.unpack(head)[2]
        return head + self._exactly(length - 1, until_s)

    def close(self) -> None:
        """See `Transport.close`."""
        self._socket.close()

    def _exactly(self, count: int, until_s: float) -> bytes:
        data = b""
        while len(data) < count:
            left_s = until_s - time.monotonic()
            if left_s <= 0.0:  # it sends a little now and then
                raise TimeoutError("the answer has not come as a whole")
            self._socket.settimeout(left_s)
            piece = self._socket.recv(count - len(data))
            if not piece:
                raise ConnectionError("it has closed the connection")
            data += piece
        return data


class Wire:
    """Reads and writes registers. Several threads may use it. A failed connection is made anew."""

    def __init__(
        self, address: str, clock: Clock, transport: Callable[[], Transport] | None = None
    ) -> None:
        """`transport` opens a connection without a socket: the simulator's."""
        self.where = f"the LabJack at {address}"
        self._address = address
        self._clock = clock
        self._open = transport or self._connect
        self._transport: Transport | None = None
        self._lock = threading.Lock()
        self._number = 0
        self._answer_s = ANSWER_S

    def read(self, doing: str, *registers: Register) -> list[float]:
        """Return the values of registers, all of one request. Raises DeviceError."""
        return self.exchange(doing, (), registers)

    def write(self, doing: str, *writes: Write) -> None:
        """Write values, in this order, in one request. Raises DeviceError."""
        self.exchange(doing, writes, ())

    def exchange(
        self, doing: str, writes: Sequence[Write], reads: Sequence[Register]
    ) -> list[float]:
        """Write, then read, in one request (Modbus Feedback): one round trip."""
        frames = b"".join(
            struct.pack(">BHB", 1, each.register.address, each.register.kind.registers)
            + each.register.kind.pack(each.value)
            for each in writes
        )
        frames += b"".join(struct.pack(">BHB", 0, r.address, r.kind.registers) for r in reads)
        data = self._request(doing, bytes([FEEDBACK]) + frames)
        self._require(len(data) == sum(2 * r.kind.registers for r in reads), doing)
        found = []
        for register in reads:
            size = 2 * register.kind.registers
            found.append(register.kind.unpack(data[:size]))
            data = data[size:]
        return found

    def read_block(self, doing: str, address: int, registers: int) -> bytes:
        """Return so many registers from an address on, as they come."""
        data = self._request(doing, struct.pack(">BHH", READ, address, registers))
        self._require(len(data) == 1 + 2 * registers and data[0] == 2 * registers, doing)
        return data[1:]

    def write_block(self, doing: str, address: int, data: bytes) -> None:
        """Write consecutive registers."""
        request = struct.pack(">BHHB", WRITE, address, len(data) // 2, len(data)) + data
        self._require(len(self._request(doing, request)) == 4, doing)

    def close(self) -> None:
        """End the connection. May be called twice; the next request makes a new one."""
        transport, self._transport = self._transport, None
        if transport is not None:
            with suppress(OSError):
                transport.close()

    def _request(self, doing: str, pdu: bytes) -> bytes:
        """Return what follows the function in the answer."""
        with self._turn(doing):
            answer = self._answer(doing, pdu)
            if answer[0] == pdu[0]:
                return answer[1:]
            self._require(answer[0] == pdu[0] | 0x80 and len(answer) == 2, doing)
            detail = self._detail()
        raise refused(doing, self.where, answer[1], detail)

    @contextmanager
    def _turn(self, doing: str) -> Iterator[None]:
        """Hold the connection. Raises DeviceTimeoutError where another thread keeps it.

        Waits by the clock: a virtual one stands still for a thread that waits by anything else.
        """
        until_s = self._clock.now() + _TURN_S
        while not self._lock.acquire(blocking=False):
            if self._clock.now() >= until_s:
                raise DeviceTimeoutError(
                    f"{doing} failed: {self.where} has not answered an earlier request; check its "
                    "cable and the network"
                )
            self._clock.sleep_until(self._clock.now() + _LOOK_S)
        try:
            yield
        finally:
            self._lock.release()

    def _detail(self) -> int:
        """Return LabJack's own code of the last error; 0: it cannot be asked."""
        with suppress(DeviceError):
            answer = self._answer("asking why", struct.pack(">BHH", READ, LAST_ERROR.address, 1))
            if answer[0] == READ and len(answer) == 4:
                return int(struct.unpack(">H", answer[2:])[0])
        return 0

    def _answer(self, doing: str, pdu: bytes) -> bytes:
        self._number = (self._number + 1) % 65536
        try:
            if self._transport is None:
                self._transport = self._open()
            head = _HEAD.pack(self._number, 0, len(pdu) + 1, _UNIT)
            answer = self._transport.exchange(head + pdu, self._answer_s)
            self._answer_s = ANSWER_S
        except TimeoutError as fault:
            self._answer_s = HURRIED_S
            self.close()  # the answer may still come: to nobody
            raise DeviceTimeoutError(
                f"{doing} failed: {self.where} did not answer in the time this can take; check "
                "its cable and the network"
            ) from fault
        except OSError as fault:
            self.close()
            raise DeviceNotFoundError(
                f"{doing} failed: no connection to {self.where}; check its power, its address and "
                f"the network ({fault})"
            ) from fault
        number, protocol, length, _ = (
            _HEAD.unpack_from(answer) if len(answer) > _HEAD.size else (0,) * 4
        )
        good = number == self._number and protocol == 0 and length == len(answer) - 6
        self._require(good, doing)
        return answer[_HEAD.size :]

    def _require(self, good: bool, doing: str) -> None:
        """Refuse an answer that does not fit; what follows it would not, either."""
        if not good:
            self.close()
            raise DeviceError(
                f"{doing} failed: {self.where} gave an answer that makes no sense; check that it "
                "is a T4, T7 or T8, and restart it"
            )

    def _connect(self) -> Transport:
        return SocketTransport(*host_and_port(self._address))
