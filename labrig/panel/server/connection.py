"""A page's connections, as far as uvicorn's own do not hold."""

from __future__ import annotations

import asyncio
import logging
import socket
from contextlib import suppress
from functools import partial
from typing import Any

import h11
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.exceptions import InvalidState

from labrig.panel.access.credentials import has_token
from labrig.panel.access.open_connections import HEAD_S, UnidentifiedConnections
from labrig.panel.access.rate_limits import Buckets

_END_OF_HEAD = b"\r\n\r\n"
_SENTENCE = b'{"error":"that is too often; wait a second."}'
_TOO_OFTEN = (
    b"HTTP/1.1 429 Too Many Requests\r\nconnection: close\r\ncontent-type: application/json\r\n"
    b"content-length: %d\r\n\r\n" % len(_SENTENCE)
) + _SENTENCE


class PageConnection(WebSocketsSansIOProtocol):
    """Ends with the panel, also in the middle of being closed by its page.

    uvicorn would say goodbye to such a page, which raises, and the panel would not be shut down in
    order. A page is in that state for long when it has not taken what was sent to it before.
    """

    def shutdown(self) -> None:
        """Close it with the panel."""
        with suppress(InvalidState):
            return super().shutdown()
        self.transport.close()
        return None


class RequestConnection(H11Protocol):
    """Has a deadline for its first request, and makes room for others until it shows the token."""

    def __init__(
        self,
        *arguments: Any,
        token: str,
        unidentified: UnidentifiedConnections[RequestConnection],
        budgets: Buckets,
        **options: Any,
    ) -> None:
        super().__init__(*arguments, **options)
        self._token = token
        self._unidentified = unidentified
        self._budgets = budgets
        self._deadline: asyncio.TimerHandle | None = None
        self._begun = False  # something of a request has come

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Wait for a request, but not for ever."""
        super().connection_made(transport)
        self._unidentified.add(self)
        self._deadline = self.loop.call_later(HEAD_S, self.drop)

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget it."""
        self._forget()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Refuse a flood before it costs anything: access control would refuse it as well."""
        if self._is_one_too_many(data):
            self.transport.write(_TOO_OFTEN)
            self.transport.close()
            return
        self._begun = True
        super().data_received(data)

    def _is_one_too_many(self, data: bytes) -> bool:
        """Whether this is a whole head without the token, of an address that has spent its budget.

        A head that comes in parts is left to access control.
        """
        if self._begun or self.client is None or not self._budgets.spent(self.client[0]):
            return False
        return _END_OF_HEAD in data and self._token.encode() not in data

    def handle_events(self) -> None:
        """Serve what has come; see whether it shows the token."""
        before = self.scope
        super().handle_events()
        if self.scope is not before:
            self._stop_deadline()
            if has_token(_text_of(self.headers), self._token):
                self._unidentified.discard(self)

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Hand it on: a page's socket without the token is closed at once."""
        self._forget()
        super().handle_websocket_upgrade(event)

    def drop(self) -> None:
        """Close it without a word."""
        self._forget()
        self.transport.abort()

    def _forget(self) -> None:
        self._stop_deadline()
        self._unidentified.discard(self)

    def _stop_deadline(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None


def _text_of(headers: list[tuple[bytes, bytes]]) -> dict[str, str]:
    return {name.decode("latin-1"): value.decode("latin-1") for name, value in headers}


def request_connections(token: str, budgets: Buckets) -> type[asyncio.Protocol]:
    """Return what uvicorn makes of each connection; all of them share one bound.

    `budgets`: how often an address may ask without the token.
    """
    unidentified: UnidentifiedConnections[RequestConnection] = UnidentifiedConnections(
        RequestConnection.drop
    )

    class Bounded(RequestConnection):
        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(
                *arguments, token=token, unidentified=unidentified, budgets=budgets, **options
            )

    return Bounded


class PanelServer(uvicorn.Server):
    """Also a handshake of TLS has a deadline, which uvicorn does not hand on.

    What a page still asks when the panel is ended is cut off without a word: it is no error.
    """

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Listen."""
        if self.config.is_ssl:
            loop: Any = asyncio.get_running_loop()
            loop.create_server = partial(loop.create_server, ssl_handshake_timeout=HEAD_S)
        await super().startup(sockets)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Close all connections."""
        logging.getLogger("uvicorn.error").setLevel(logging.CRITICAL)
        await super().shutdown(sockets)
