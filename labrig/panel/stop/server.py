"""The STOP process's server: `/stop`, and nothing else.

One thread reads all connections, so a thousand that say nothing cost no thread each. Who shows the
token is served; who does not has a small budget, a deadline, and makes room for the next.
"""

from __future__ import annotations

import asyncio
import json
import socket
import ssl
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from labrig.panel.access.open_connections import (
    HEAD_S,
    LISTEN_BACKLOG,
    UnidentifiedConnections,
)
from labrig.panel.access.rate_limits import Buckets
from labrig.panel.stop.press import StopConnection
from labrig.panel.stop.request import Head, StopSettings, head_of, refusal_of

MOST_HEAD_BYTES = 16 << 10
MOST_BODY_BYTES = 4096
MOST_DRAINED_BYTES = 256 << 10
MOST_PRESSES = 32  # at a time; each may wait for `labrig safe`
_BODY_S = 1.0  # whatever the body holds, or does not: STOP was pressed
_DRAIN_S = 1.0  # with a client that has its answer and is still sending
_UNIDENTIFIED = (20.0, 120.0)  # requests of one address: in a second, and at once

Answer = dict[str, Any]


@dataclass(frozen=True, eq=False)
class _Client:
    reader: asyncio.StreamReader
    writer: asyncio.StreamWriter

    @property
    def address(self) -> str:
        peer = self.writer.get_extra_info("peername")
        return str(peer[0]) if peer else "unknown"


class StopServer:
    """Serves in a thread of its own from `start` to the end of the process."""

    def __init__(self, settings: StopSettings, line: StopConnection) -> None:
        self._settings = settings
        self._line = line
        self._listening = _bound(settings)
        self._unidentified: UnidentifiedConnections[_Client] = UnidentifiedConnections(
            lambda client: client.writer.transport.abort()
        )
        self._budget = Buckets(*_UNIDENTIFIED)
        self._presses = ThreadPoolExecutor(MOST_PRESSES, "press")
        self._tls = _tls(settings)

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self._listening.getsockname()[1])

    def start(self) -> None:
        """Serve from now on."""
        work = threading.Thread(target=asyncio.run, args=(self._serve_all(),), name="http")
        work.daemon = True
        work.start()

    async def _serve_all(self) -> None:
        server = await asyncio.start_server(
            self._serve,
            sock=self._listening,
            backlog=LISTEN_BACKLOG,
            limit=MOST_HEAD_BYTES,
            ssl=self._tls,
            ssl_handshake_timeout=None if self._tls is None else HEAD_S,
        )
        await server.serve_forever()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        client = _Client(reader, writer)
        self._unidentified.add(client)
        try:
            async with asyncio.timeout(HEAD_S):
                head = head_of(await reader.readuntil(b"\r\n\r\n"))
            await self._answer(client, head)
        except (OSError, ValueError, EOFError, asyncio.LimitOverrunError, TimeoutError):
            pass  # it went away, came too late, or speaks something else
        finally:
            self._unidentified.discard(client)
            writer.transport.abort()

    async def _answer(self, client: _Client, head: Head) -> None:
        refused = refusal_of(head, self._settings)
        if refused is None:
            self._unidentified.discard(client)
            await self._send(client, head, 200, await self._done(client, head))
        elif not self._budget.take(client.address):
            await self._send(client, head, 429, {"error": "that is too often; wait a second."})
            return
        else:
            await self._send(client, head, *refused)
        await _drain(client)

    async def _done(self, client: _Client, head: Head) -> Answer:
        if head.method == "GET":
            return {"ready": True, "going": self._line.going}
        asked = await _body(client.reader, head)
        name = " ".join(str(asked.get("name") or "somebody").split())[:40]
        who, why = f"{name} ({client.address})", str(asked.get("why") or "")[:200]
        loop = asyncio.get_running_loop()
        pressed = await loop.run_in_executor(self._presses, self._line.press, who, why)
        return pressed.as_dict()

    async def _send(self, client: _Client, head: Head, status: int, body: Answer | None) -> None:
        client.writer.write(_packed(status, body, head.origin(self._settings)))
        async with asyncio.timeout(HEAD_S):
            await client.writer.drain()


async def _body(reader: asyncio.StreamReader, head: Head) -> Answer:
    """Return what a press says, as far as it can be understood."""
    found: Any = {}
    with suppress(ValueError, RecursionError, OSError, EOFError, TimeoutError):
        async with asyncio.timeout(_BODY_S):
            found = json.loads(await reader.readexactly(head.body_bytes(MOST_BODY_BYTES)))
    return found if isinstance(found, dict) else {}


async def _drain(client: _Client) -> None:
    """End the answer and read what is still sent: else the answer may be lost.

    Closing a connection on which something is still coming resets it.
    """
    if client.writer.can_write_eof():
        client.writer.write_eof()
    drained = 0
    with suppress(TimeoutError):
        async with asyncio.timeout(_DRAIN_S):
            while drained < MOST_DRAINED_BYTES:
                part = await client.reader.read(1 << 16)
                if not part:
                    return
                drained += len(part)


def _packed(status: int, body: Answer | None, origin: str | None) -> bytes:
    text = b"" if body is None else json.dumps(body).encode()
    lines = [
        f"HTTP/1.1 {status} {_REASONS[status]}",
        "Connection: close",
        "Content-Type: application/json",
        f"Content-Length: {len(text)}",
    ]
    if origin is not None:
        lines += [
            f"Access-Control-Allow-Origin: {origin}",
            "Access-Control-Allow-Credentials: true",
            "Access-Control-Allow-Headers: Content-Type, X-Labrig-Client",
            "Access-Control-Allow-Methods: POST, GET",
        ]
    return "\r\n".join([*lines, "", ""]).encode("latin-1") + text


_REASONS = {
    200: "OK",
    204: "No Content",
    401: "Unauthorized",
    403: "Forbidden",
    404: "Not Found",
    405: "Method Not Allowed",
    429: "Too Many Requests",
}


def _bound(settings: StopSettings) -> socket.socket:
    """Return a socket at the wanted port, else at another free one."""
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    try:
        return socket.create_server(
            (settings.host, settings.port), family=family, backlog=LISTEN_BACKLOG
        )
    except OSError:
        return socket.create_server((settings.host, 0), family=family, backlog=LISTEN_BACKLOG)


def _tls(settings: StopSettings) -> ssl.SSLContext | None:
    if settings.certificate is None:
        return None
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(settings.certificate, settings.key)
    return context
