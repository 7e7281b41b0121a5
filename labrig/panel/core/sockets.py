"""Sockets of pages: a slow page gets fewer messages, and nobody waits for it."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Any

from fastapi import WebSocket, WebSocketDisconnect

from labrig.panel.access.rate_limits import Bucket
from labrig.panel.core.control import as_seen_by
from labrig.panel.live.event_stream import EventStream, Mail, Mailbox, Message
from labrig.panel.live.packing import dumps, pack

MOST_MESSAGE_BYTES = 4096  # of what a page says
SEND_S = 15.0  # a page that takes nothing for so long is let go; it comes again when it lives
_TOO_OFTEN = (20.0, 40.0)
_NEWEST_EVERY_S = 0.015  # what comes meanwhile is sent together; well below a camera's period

OnMessage = Callable[[Message], Awaitable[None]]


def address_of(socket: Any) -> str:
    """Where a request comes from."""
    return "unknown" if socket.client is None else str(socket.client.host)


async def together(*parts: Awaitable[None]) -> None:
    """All of them until the first one ends."""
    tasks = [asyncio.ensure_future(part) for part in parts]
    try:
        done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        for task in done:
            task.result()
    except (WebSocketDisconnect, TimeoutError, RuntimeError):
        pass  # it has gone, or it takes nothing any more
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


async def receive_messages(socket: WebSocket, on_message: OnMessage) -> None:
    """Receive a page's messages; one that sends too much is disconnected."""
    bucket = Bucket(*_TOO_OFTEN)
    while True:
        event = await socket.receive()
        if event["type"] == "websocket.disconnect":
            return
        text = event.get("text")
        if not bucket.take():
            await socket.close(1008, "that is too often.")
            return
        if text is None or len(text) > MOST_MESSAGE_BYTES:
            await socket.close(1009, "that is too long.")
            return
        try:
            message = json.loads(text)
        except (ValueError, RecursionError):
            continue
        if isinstance(message, dict):
            if message.get("do") == "ping":
                await asyncio.wait_for(socket.send_text('{"type":"pong"}'), SEND_S)
            else:
                await on_message(message)


class Post:
    """Deliver an event stream to one page."""

    def __init__(self, socket: WebSocket, stream: EventStream, client: str = "") -> None:
        self._socket = socket
        self._stream = stream
        self._client = client
        self._loop = asyncio.get_running_loop()
        self._news = asyncio.Event()
        self._box = Mailbox(self._wake)

    async def send(self, message: Message) -> None:
        """One message, past the stream."""
        await asyncio.wait_for(self._socket.send_text(dumps(message)), SEND_S)

    async def deliver(self) -> None:
        """Send all that is published, until the page has gone. Raises TimeoutError."""
        self._stream.join(self._box)
        while True:
            await self._news.wait()
            self._news.clear()
            while (mail := self._box.take()) is not None:
                for packed in _packed(mail, self._client):
                    await asyncio.wait_for(self._out(packed), SEND_S)
            await asyncio.sleep(_NEWEST_EVERY_S)

    def close(self) -> None:
        """Stop: the page has gone."""
        self._stream.leave(self._box)

    async def _out(self, packed: str | bytes) -> None:
        if isinstance(packed, str):
            await self._socket.send_text(packed)
        else:
            await self._socket.send_bytes(packed)

    def _wake(self) -> None:
        with suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(self._news.set)


def _packed(mail: Mail, client: str) -> list[str | bytes]:
    found: list[str | bytes] = []
    if mail.story is not None:
        found.append(dumps({"type": "story", "messages": mail.story}))
    found += [dumps(message) for message in mail.messages]
    found += [dumps(as_seen_by(client, message)) for message in mail.newest]
    if mail.strip is not None:
        found.append(mail.strip.packed())
    if mail.picture is not None:
        found.append(pack(*mail.picture))
    return found
