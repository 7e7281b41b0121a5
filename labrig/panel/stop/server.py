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
from typing import Any

from labrig.panel.access.open_connections import (
    HEAD_S,
    LISTEN_BACKLOG,
    UnidentifiedConnections,
)
from labrig.panel.access.rate_limits import UNIDENTIFIED, Buckets
from labrig.panel.stop.client import Client
from labrig.panel.stop.press import StopConnection
from labrig.panel.stop.request import Head, StopSettings, head_of, refusal_of

MOST_BODY_BYTES = 4096
MOST_DRAINED_BYTES = 256 << 10
MOST_PRESSES = 32  # at a time; each may wait for `labrig safe`
_BODY_S = 1.0  # whatever the body holds, or does not: STOP was pressed
_DRAIN_S = 1.0  # with a client that has its answer and is still sending

_FLOOD = {"error": "that is too often; wait a second."}

Answer = dict[str, Any]


class StopServer:
    """Serves in a thread of its own from `start` to the end of the process."""

    def __init__(self, settings: StopSettings, line: StopConnection) -> None:
        self._settings = settings
        self._line = line
        self._listening = _bound(settings)
        self._unidentified: UnidentifiedConnections[Client] = UnidentifiedConnections(Client.drop)
        self._budgets = Buckets(*UNIDENTIFIED)
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
        server = await asyncio.get_running_loop().create_server(
            self._client,
            sock=self._listening,
            backlog=LISTEN_BACKLOG,
            ssl=self._tls,
            ssl_handshake_timeout=None if self._tls is None else HEAD_S,
        )
        await server.serve_forever()

    def _client(self) -> Client:
        too_often = _packed(429, _FLOOD, None)
        token = self._settings.token
        return Client(self._serve, too_often, token, self._unidentified, self._budgets)

    async def _serve(
        self, client: Client, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        with suppress(OSError, ValueError, EOFError, asyncio.LimitOverrunError, TimeoutError):
            head = head_of(await reader.readuntil(b"\r\n\r\n"))
            client.head_came()
            if await self._answer(client, head, reader, writer):
                await _drain(reader, writer)
        writer.transport.abort()

    async def _answer(
        self,
        client: Client,
        head: Head,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
    ) -> bool:
        """Answer; return whether the rest of the request is to be read."""
        refused = refusal_of(head, self._settings)
        too_often = refused is not None and not self._budgets.take(client.address)
        body: Answer | None
        if too_often:
            status, body = 429, _FLOOD
        elif refused is not None:
            status, body = refused
        else:
            client.identified()
            status, body = 200, await self._done(client, head, reader)
        writer.write(_packed(status, body, head.origin(self._settings)))
        async with asyncio.timeout(HEAD_S):
            await writer.drain()
        return not too_often

    async def _done(self, client: Client, head: Head, reader: asyncio.StreamReader) -> Answer:
        if head.method == "GET":
            return {"ready": True, "going": self._line.going}
        asked = await _body(reader, head)
        name = " ".join(str(asked.get("name") or "somebody").split())[:40]
        who, why = f"{name} ({client.address})", str(asked.get("why") or "")[:200]
        loop = asyncio.get_running_loop()
        pressed = await loop.run_in_executor(self._presses, self._line.press, who, why)
        return pressed.as_dict()


async def _body(reader: asyncio.StreamReader, head: Head) -> Answer:
    """Return what a press says, as far as it can be understood."""
    found: Any = {}
    with suppress(ValueError, RecursionError, OSError, EOFError, TimeoutError):
        async with asyncio.timeout(_BODY_S):
            found = json.loads(await reader.readexactly(head.body_bytes(MOST_BODY_BYTES)))
    return found if isinstance(found, dict) else {}


async def _drain(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """End the answer and read what is still sent: else the answer may be lost.

    Closing a connection on which something is still coming resets it.
    """
    if writer.can_write_eof():
        writer.write_eof()
    drained = 0
    with suppress(TimeoutError):
        async with asyncio.timeout(_DRAIN_S):
            while drained < MOST_DRAINED_BYTES:
                part = await reader.read(1 << 16)
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
