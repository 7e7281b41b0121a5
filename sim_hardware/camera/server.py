"""The simulated camera on the network: a stream that `cv2.VideoCapture(url)` reads byte by byte.

YUV4MPEG2 with the colour space `mono` holds grey pixels as they are, uncompressed.
"""

from __future__ import annotations

import contextlib
import socket
import threading
from collections import deque
from fractions import Fraction

from drivers.interfaces import Clock
from sim_hardware.camera.faults import CameraFaults
from sim_hardware.camera.stream import FrameStream, Image
from sim_hardware.simulated_rig import OpticalSide

_POLL_S = 0.05
_BUFFERED = 4  # frames kept for a client that is busy for a moment
_HEADER = (
    b"HTTP/1.0 200 OK\r\nServer: labrig simulated camera\r\n"
    b"Content-Type: video/x-yuv4mpeg\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n"
)


class _Client:
    """One connection, and the frames that wait for it."""

    def __init__(self, connection: socket.socket) -> None:
        self.connection = connection
        self.frames: deque[tuple[int, Image]] = deque(maxlen=_BUFFERED)
        self.thread: threading.Thread | None = None

    def receive_request(self) -> str:
        """Return the method of the HTTP request; empty when none came."""
        self.connection.settimeout(5)
        received = b""
        while b"\r\n\r\n" not in received and len(received) < 65536:
            more = self.connection.recv(4096)
            if not more:
                return ""
            received += more
        self.connection.settimeout(None)
        return received.split(b" ", 1)[0].decode("ascii", "replace")


class CameraServer:
    """Serves http://127.0.0.1:PORT/ in real time to any number of clients.

    A frame is rendered once, and only while a client reads. A client that reads slowly misses
    frames; nothing piles up. Each frame's header carries its number (`Xnumber=`).
    """

    def __init__(
        self, scene: OpticalSide, clock: Clock, port: int = 0, *, faults: CameraFaults | None = None
    ) -> None:
        self.faults = faults if faults is not None else CameraFaults()
        self._clock = clock
        self._stream = FrameStream(scene, clock.now(), self.faults)
        self._change = threading.Condition()
        self._ended = False  # no more frames will come
        self._clients: set[_Client] = set()
        self._listener = socket.create_server(("127.0.0.1", port))
        self._listener.settimeout(_POLL_S)
        self.url = f"http://127.0.0.1:{self._listener.getsockname()[1]}/"
        self._threads = [
            threading.Thread(target=self._accept, name="camera-accept", daemon=True),
            threading.Thread(target=self._produce, name="camera-frames", daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """End all connections and threads. May be called twice."""
        self._end()
        for thread in self._threads:
            thread.join(timeout=5)
        with self._change:
            clients = list(self._clients)
        for client in clients:
            with contextlib.suppress(OSError):
                client.connection.shutdown(socket.SHUT_RDWR)
            if client.thread is not None:
                client.thread.join(timeout=5)
        self._listener.close()

    def _end(self) -> None:
        with self._change:
            self._ended = True
            self._change.notify_all()

    # ------------------------------------------------------------------------------------ frames

    def _produce(self) -> None:
        number = 0
        try:
            while self._wait_for(number) and not self._stream.suffers("gone", number):
                with self._change:
                    watched = bool(self._clients)
                if watched and not self._stream.suffers("drop", number):
                    self._publish(number, self._stream.image(number))
                oldest = self._stream.latest_at(self._clock.now()) - _BUFFERED + 1
                number = max(number + 1, oldest)
        finally:
            self._end()

    def _wait_for(self, number: int) -> bool:
        """Wait for the frame; False when the server stops."""
        arrival = self._stream.arrival_of(number)
        while not self._ended:
            now = self._clock.now()
            if now >= arrival:
                return True
            self._clock.sleep_until(min(arrival, now + _POLL_S))
        return False

    def _publish(self, number: int, image: Image) -> None:
        with self._change:
            for client in self._clients:
                client.frames.append((number, image))
            self._change.notify_all()

    # ----------------------------------------------------------------------------------- clients

    def _accept(self) -> None:
        while not self._ended:
            try:
                connection, _ = self._listener.accept()
            except TimeoutError:
                continue
            rows, columns = self._stream.scene.frame_shape
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, rows * columns)
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            client = _Client(connection)
            client.thread = threading.Thread(
                target=self._serve, args=(client,), name="camera-client", daemon=True
            )
            with self._change:
                self._clients.add(client)
            client.thread.start()

    def _serve(self, client: _Client) -> None:
        # A client may leave at any moment; that ends its connection and nothing else.
        with client.connection, contextlib.suppress(OSError):
            method = client.receive_request()
            if method in ("GET", "HEAD"):
                client.connection.sendall(_HEADER)
            if method == "GET":
                self._send_frames(client)
        with self._change:
            self._clients.discard(client)

    def _send_frames(self, client: _Client) -> None:
        shape: tuple[int, ...] | None = None
        while (frame := self._next_frame(client)) is not None:
            number, image = frame
            if shape is None:
                shape = image.shape
                client.connection.sendall(self._stream_header(*image.shape))
            if image.shape != shape:
                return  # a stream has one size; a client that opens it again gets the new one
            client.connection.sendall(b"FRAME Xnumber=%d\n" % number + image.tobytes())

    def _next_frame(self, client: _Client) -> tuple[int, Image] | None:
        with self._change:
            self._change.wait_for(lambda: client.frames or self._ended)
            return None if self._ended else client.frames.popleft()

    def _stream_header(self, rows: int, columns: int) -> bytes:
        rate = Fraction(self._stream.scene.frame_rate_hz).limit_denominator(1001)
        return (
            f"YUV4MPEG2 W{columns} H{rows} F{rate.numerator}:{rate.denominator} Ip A1:1 Cmono\n"
        ).encode("ascii")
