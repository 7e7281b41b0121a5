"""The body of one request: read up to a limit, and drained after a refusal.

Closing a connection on which something is still coming resets it, and whoever is sending may lose
the answer: a browser then shows a fault of the network in place of our sentence. So who is refused
is answered first, and then heard out, up to limits.
"""

from __future__ import annotations

import asyncio
from contextlib import suppress

from starlette.types import Message, Receive

MOST_BODY_BYTES = 256 << 10
# Of a photograph; nobody comes as far as its path without the token.
LARGER_BODIES_BYTES = {"/api/notes/photograph": 16 << 20}
_DRAINED = 4  # times what is accepted
DRAIN_S = 1.0  # with who was refused, and is still sending


def body_limit(path: str) -> int:
    """Return how many bytes the body of a request for this path may have."""
    return LARGER_BODIES_BYTES.get(path, MOST_BODY_BYTES)


class RequestBody:
    """What comes after the head of a request."""

    def __init__(self, receive: Receive, most_bytes: int = MOST_BODY_BYTES) -> None:
        self.most_bytes = most_bytes
        self._receive = receive
        self._seen = 0
        self._ended = False

    @property
    def too_large(self) -> bool:
        """Whether more has come than is accepted, whatever its stated length."""
        return self._seen > self.most_bytes

    async def take(self) -> Message:
        """Return the next part (see ASGI); none of a body that is too large."""
        message = await self._next()
        return {"type": "http.disconnect"} if self.too_large else message

    async def drain(self) -> None:
        """Forget what is still coming. Call it when the answer is sent, but not yet closed."""
        with suppress(TimeoutError):
            async with asyncio.timeout(DRAIN_S):
                while not self._ended and self._seen < _DRAINED * self.most_bytes:
                    await self._next()

    async def _next(self) -> Message:
        message = await self._receive()
        self._seen += len(message.get("body", b""))
        self._ended = not message.get("more_body", False)  # nor is there more of who is gone
        return message
