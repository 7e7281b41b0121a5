"""A connection to the STOP process: silent ones and floods cost next to nothing."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any, cast

from labrig.panel.access.open_connections import HEAD_S, UnidentifiedConnections
from labrig.panel.access.rate_limits import Buckets

MOST_HEAD_BYTES = 16 << 10
_END_OF_HEAD = b"\r\n\r\n"

Serve = Callable[["Client", asyncio.StreamReader, asyncio.StreamWriter], Awaitable[None]]


class Client(asyncio.StreamReaderProtocol):
    """Served by a task of its own from its first byte; before that it only has a deadline."""

    def __init__(
        self,
        serve: Serve,
        too_often: bytes,
        token: str,
        unidentified: UnidentifiedConnections[Client],
        budgets: Buckets,
    ) -> None:
        """`too_often`: what is answered to a flood, without reading what it asks for."""
        reader = asyncio.StreamReader(MOST_HEAD_BYTES)
        super().__init__(reader, lambda reader, writer: serve(self, reader, writer))
        self.address = "unknown"
        self._too_often = too_often
        self._token = token.encode()
        self._unidentified = unidentified
        self._budgets = budgets
        self._begun = False

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Wait for a request, but not for ever."""
        self._early = cast("asyncio.Transport", transport)
        peer: Any = transport.get_extra_info("peername")
        self.address = str(peer[0]) if peer else self.address
        self._unidentified.add(self)
        self._deadline = asyncio.get_running_loop().call_later(HEAD_S, self.drop)

    def data_received(self, data: bytes) -> None:
        """Refuse a flood at once; else see `StreamReaderProtocol`."""
        if not self._begun:
            if self._is_one_too_many(data):
                self._early.write(self._too_often)
                self._early.close()
                return
            self._begun = True
            super().connection_made(self._early)
        super().data_received(data)

    def eof_received(self) -> bool | None:
        """See `StreamReaderProtocol`."""
        return super().eof_received() if self._begun else False

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget it."""
        self.identified()
        self.head_came()
        if self._begun:
            super().connection_lost(exc)

    def head_came(self) -> None:
        """End the deadline."""
        self._deadline.cancel()

    def identified(self) -> None:
        """Keep it: it has shown the token."""
        self._unidentified.discard(self)

    def drop(self) -> None:
        """Close it without a word."""
        self._early.abort()

    def _is_one_too_many(self, data: bytes) -> bool:
        """Whether this is a head without the token, of an address that has spent its budget."""
        if _END_OF_HEAD not in data or self._token in data:
            return False
        return self._budgets.spent(self.address)
