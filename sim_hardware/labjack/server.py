"""The device on a TCP port of this computer, or reached in this process."""

from __future__ import annotations

import contextlib
import errno
import socket
import threading

from sim_hardware.labjack.device import SimulatedLabJack
from sim_hardware.labjack.requests import HEAD, answer, asks_for_stream
from sim_hardware.port_taken import PortTakenError

HOST = "127.0.0.1"
_LOOK_S = 0.01  # how often the watchdog is looked after where no request comes


class InProcess:
    """A connection without a socket, which a client uses as one that is connected."""

    def __init__(self, device: SimulatedLabJack) -> None:
        """Connect. OSError while the device is away."""
        self._device = device
        self._refuse()

    def exchange(self, request: bytes, answer_s: float) -> bytes:
        """Return the answer to a request, which is waited for so long. OSError."""
        device, clock = self._device, self._device.clock
        self._refuse()
        if device.faults.hang or (device.faults.hang_stream and asks_for_stream(request)):
            clock.sleep_until(clock.now() + answer_s)
            raise TimeoutError("timed out")
        if device.faults.delay_s:
            clock.sleep_until(clock.now() + device.faults.delay_s)
        return answer(device, request)

    def close(self) -> None:
        """Nothing is held."""

    def _refuse(self) -> None:
        if self._device.faults.unavailable:
            raise ConnectionRefusedError(errno.ECONNREFUSED, "connection refused")


class LabJackServer:
    """Answers for a device on a port. `cut` ends the connections there are, as a pulled cable."""

    def __init__(self, device: SimulatedLabJack, port: int = 0) -> None:
        """PortTakenError."""
        self._device = device
        try:
            self._listener = socket.create_server((HOST, port))
        except OSError as fault:
            raise PortTakenError(f"port {port} cannot be taken: {fault}") from fault
        self.port = int(self._listener.getsockname()[1])
        self._clients: set[socket.socket] = set()
        self._lock = threading.Lock()
        self._ended = threading.Event()
        for target, name in ((self._accept, "labjack"), (self._look, "labjack watchdog")):
            threading.Thread(target=target, name=name, daemon=True).start()

    def cut(self) -> None:
        """End every connection."""
        with self._lock:
            clients = list(self._clients)
        for client in clients:
            with contextlib.suppress(OSError):
                client.shutdown(socket.SHUT_RDWR)

    def stop(self) -> None:
        """Listen no more. May be called twice."""
        self._ended.set()
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self.cut()

    def _look(self) -> None:
        while not self._ended.wait(_LOOK_S):
            self._device.advance()

    def _accept(self) -> None:
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            if self._device.faults.unavailable:
                client.close()
                continue
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            with self._lock:
                self._clients.add(client)
            threading.Thread(
                target=self._serve, args=(client,), name="labjack client", daemon=True
            ).start()

    def _serve(self, client: socket.socket) -> None:
        faults = self._device.faults
        with client, contextlib.suppress(OSError, ValueError):
            while not faults.unavailable:
                request = _request(client)
                if not request or faults.unavailable:
                    break
                if faults.hang or (faults.hang_stream and asks_for_stream(request)):
                    continue
                self._ended.wait(faults.delay_s)
                client.sendall(answer(self._device, request))
        with self._lock:
            self._clients.discard(client)


def _request(client: socket.socket) -> bytes:
    """Return a whole request; empty: the client has gone."""
    head = _exactly(client, HEAD.size)
    if len(head) < HEAD.size:
        return b""
    length = HEAD.unpack(head)[2]
    if not 2 <= length <= 1040:
        raise ValueError("no Modbus TCP")
    return head + _exactly(client, length - 1)


def _exactly(client: socket.socket, count: int) -> bytes:
    data = b""
    while len(data) < count:
        piece = client.recv(count - len(data))
        if not piece:
            return b""
        data += piece
    return data
