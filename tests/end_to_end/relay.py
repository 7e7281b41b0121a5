"""A network between two programs, which a test can cut: bytes stop, and no end is told.

`mend` serves new connections again. Those that were cut stay dead.
"""

from __future__ import annotations

import contextlib
import socket
import threading


class Relay:
    """Hands connections on to a port; `cut` lets every byte vanish from then on."""

    def __init__(self, port: int) -> None:
        self._to = port
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = int(self._listener.getsockname()[1])
        self._is_cut = threading.Event()
        self._ends: list[socket.socket] = []
        threading.Thread(target=self._accept, daemon=True).start()

    def cut(self) -> None:
        """Pull the cable."""
        self._is_cut.set()

    def mend(self) -> None:
        """Plug a new cable in."""
        self._is_cut = threading.Event()

    def stop(self) -> None:
        """Close everything."""
        for end in (self._listener, *self._ends):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
            end.close()

    def _accept(self) -> None:
        while True:
            try:
                client, _ = self._listener.accept()
                server = socket.create_connection(("127.0.0.1", self._to))
            except OSError:
                return
            self._ends += [client, server]
            for source, sink in ((client, server), (server, client)):
                source.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                ends = (source, sink, self._is_cut)
                threading.Thread(target=self._pump, args=ends, daemon=True).start()

    @staticmethod
    def _pump(source: socket.socket, sink: socket.socket, is_cut: threading.Event) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(65536):
                if not is_cut.is_set():
                    sink.sendall(data)
            if not is_cut.is_set():
                sink.shutdown(socket.SHUT_RDWR)
