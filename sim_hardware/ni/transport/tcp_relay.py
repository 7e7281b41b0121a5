"""Hands TCP connections on to the server and notices when one closes.

A gRPC server in Python is not notified that a client has gone; a local driver does. With strict
ownership the relay stands in front, so that a dead client's tasks can be cleared.
"""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Callable

_CHUNK = 1 << 16


class ByteRelay:
    """Listens on a port; each connection gets one of its own to the server."""

    def __init__(
        self, host: str, port: int, server_port: int, client_gone: Callable[[str], None]
    ) -> None:
        """OSError when the port is taken. `client_gone` gets the name the server knows it by."""
        self._server = (host, server_port)
        self._client_gone = client_gone
        self._listener = socket.create_server((host, port))
        self.port = int(self._listener.getsockname()[1])
        self._open: set[socket.socket] = set()
        self._lock = threading.Lock()
        threading.Thread(target=self._accept, name="ni-relay", daemon=True).start()

    def stop(self) -> None:
        """Close everything. May be called twice."""
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)  # wakes `accept`
        self._listener.close()
        with self._lock:
            ends = list(self._open)
        for end in ends:
            _shut(end)

    def _accept(self) -> None:
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            threading.Thread(
                target=self._serve, args=(client,), name="ni-relay client", daemon=True
            ).start()

    def _serve(self, client: socket.socket) -> None:
        """One connection, from its beginning to its end."""
        try:
            server = socket.create_connection(self._server)
        except OSError:  # the server has stopped
            client.close()
            return
        with client, server:
            for end in (client, server):
                end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            with self._lock:
                self._open |= {client, server}
            name = "ipv4:{}:{}".format(*server.getsockname())
            back = threading.Thread(
                target=_pump, args=(server, client), name="ni-relay answers", daemon=True
            )
            back.start()
            _pump(client, server)
            back.join()
            with self._lock:
                self._open -= {client, server}
        self._client_gone(name)


def _pump(source: socket.socket, sink: socket.socket) -> None:
    """Copy until either end closes; then close both."""
    with contextlib.suppress(OSError):
        while chunk := source.recv(_CHUNK):
            sink.sendall(chunk)
    _shut(source)
    _shut(sink)


def _shut(end: socket.socket) -> None:
    with contextlib.suppress(OSError):
        end.shutdown(socket.SHUT_RDWR)
