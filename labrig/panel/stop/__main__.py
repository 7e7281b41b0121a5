"""The STOP process: a tiny HTTP server with an open connection to the job.

It outlives a panel that dies while a job is going on, for the pages that are still open. Standard
library only, so that it starts at once and has little that could fail.
"""

from __future__ import annotations

import json
import socket
import socketserver
import ssl
import sys
import threading
import time
from contextlib import suppress
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from labrig.panel.access.credentials import cookie_of, same_token
from labrig.panel.access.settings import host_name
from labrig.panel.stop.press import StopConnection

CLIENT_TIMEOUT_S = 3.0  # with a client that connects and sends nothing
MOST_BODY_BYTES = 4096
MOST_DRAINED_BYTES = 256 << 10
MOST_AT_ONCE = 64
_POLL_S = 0.5
_DRAIN_S = 1.0  # with a client that has its answer and is still sending


@dataclass(frozen=True, kw_only=True)
class StopSettings:
    """What the panel says on our input, as one line of JSON."""

    host: str
    port: int  # wanted; another free one where it is in use
    scheme: str
    panel_port: int
    hosts: tuple[str, ...] | None  # by which we may be called; None: any
    token: str
    data: str
    certificate: str | None
    key: str | None


class StopServer(ThreadingHTTPServer):
    """One thread for each request, and no more of them than are good for us."""

    daemon_threads = True
    request_queue_size = 128  # a press must not wait behind those who only connect
    allow_reuse_address = sys.platform != "win32"  # there it would let others have our port, too

    def __init__(self, settings: StopSettings, line: StopConnection) -> None:
        self.settings = settings
        self.line = line
        self._room = threading.Semaphore(MOST_AT_ONCE)
        if ":" in settings.host:
            self.address_family = socket.AF_INET6
        try:
            super().__init__((settings.host, settings.port), Handler)
        except OSError:
            super().__init__((settings.host, 0), Handler)
        self._tls = _tls(settings)

    def server_bind(self) -> None:
        """Without looking for a name of this computer, which may take its time."""
        socketserver.TCPServer.server_bind(self)
        self.server_name, self.server_port = self.settings.host, self.server_address[1]

    def process_request(self, request: Any, client_address: Any) -> None:
        """In a thread of its own; the handshake, too, which a client may never end."""
        if not self._room.acquire(blocking=False):
            self.close_request(request)
            return
        super().process_request(request, client_address)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """See `ThreadingMixIn`."""
        try:
            request.settimeout(CLIENT_TIMEOUT_S)
            if self._tls is not None:
                request = self._tls.wrap_socket(request, server_side=True)
            super().process_request_thread(request, client_address)
        except OSError:
            self.shutdown_request(request)
        finally:
            self._room.release()

    def shutdown_request(self, request: Any) -> None:
        """End the answer and read what is still sent: else the answer may be lost.

        Closing a connection on which something is still coming resets it.
        """
        drained, until_s = 0, time.monotonic() + _DRAIN_S
        with suppress(OSError):
            request.shutdown(socket.SHUT_WR)
            while drained < MOST_DRAINED_BYTES and (left_s := until_s - time.monotonic()) > 0:
                request.settimeout(left_s)
                size = len(request.recv(1 << 16))
                if size == 0:
                    break
                drained += size
        self.close_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore a client that goes away."""


class Handler(BaseHTTPRequestHandler):
    """POST /stop."""

    server: StopServer
    timeout = CLIENT_TIMEOUT_S

    def do_POST(self) -> None:
        """Stop the job."""
        refused = self._refused()
        if refused is not None:
            self._answer(refused[0], {"error": refused[1]})
            return
        try:
            asked = json.loads(self.rfile.read(self._size()) or b"{}")
        except (ValueError, RecursionError, OSError):
            asked = {}  # whatever the body holds: STOP was pressed
        asked = asked if isinstance(asked, dict) else {}
        name = " ".join(str(asked.get("name") or "somebody").split())[:40]
        who = f"{name} ({self.client_address[0]})"
        pressed = self.server.line.press(who, str(asked.get("why") or "")[:200])
        self._answer(200, pressed.as_dict())

    def do_GET(self) -> None:
        """Whether we are there."""
        refused = self._refused()
        if refused is not None:
            self._answer(refused[0], {"error": refused[1]})
            return
        self._answer(200, {"ready": True, "going": self.server.line.going})

    def do_OPTIONS(self) -> None:
        """Answer a browser that asks first whether it may."""
        self._answer(204 if self._origin() else 403, None)

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002 - as the base class has it
        """Nobody reads it."""

    def _size(self) -> int:
        """Of the body, as far as it is worth reading."""
        stated = self.headers.get("Content-Length") or "0"
        return min(int(stated), MOST_BODY_BYTES) if stated.isdecimal() else 0

    def _refused(self) -> tuple[int, str] | None:
        settings = self.server.settings
        if self.path.partition("?")[0] != "/stop":
            return 404, "there is only /stop here."
        bearer = self.headers.get("Authorization", "").removeprefix("Bearer ")
        if same_token(bearer, settings.token):
            return None
        if self._origin() is None:
            return 403, "only the panel's own page may do this."
        if not same_token(cookie_of(self.headers.get("Cookie", "")), settings.token):
            return 401, "the token is missing or wrong."
        return None

    def _origin(self) -> str | None:
        """Return the asking page's origin, when it is the panel's own."""
        settings = self.server.settings
        host = host_name(self.headers.get("Host", "").lower())
        if settings.hosts is not None and host.strip("[]") not in settings.hosts:
            return None
        own = f"{settings.scheme}://{host}:{settings.panel_port}"
        return own if self.headers.get("Origin", "").lower() == own else None

    def _answer(self, status: int, body: dict[str, Any] | None) -> None:
        text = b"" if body is None else json.dumps(body).encode()
        self.send_response(status)
        origin = self._origin()
        if origin is not None:
            self.send_header("Access-Control-Allow-Origin", origin)
            self.send_header("Access-Control-Allow-Credentials", "true")
            self.send_header("Access-Control-Allow-Headers", "Content-Type, X-Labrig-Client")
            self.send_header("Access-Control-Allow-Methods", "POST, GET")
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(text)))
        self.end_headers()
        self.wfile.write(text)


def _tls(settings: StopSettings) -> ssl.SSLContext | None:
    if settings.certificate is None:
        return None
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(settings.certificate, settings.key)
    return context


def main() -> None:
    """Serve until the panel has gone and no job is going on any more."""
    settings = StopSettings(**json.loads(sys.stdin.readline()))
    line, ended = StopConnection(Path(settings.data)), threading.Event()
    server = StopServer(settings, line)
    threading.Thread(target=line.watch, args=(ended,), name="line", daemon=True).start()
    threading.Thread(target=server.serve_forever, name="http", daemon=True).start()
    sys.stdout.write(f"{server.server_address[1]}\n")
    sys.stdout.flush()
    sys.stdin.read()  # ends with the panel
    while line.going:
        ended.wait(_POLL_S)


if __name__ == "__main__":
    main()
