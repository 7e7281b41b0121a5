"""Sockets of pages: a slow page gets fewer messages, and nobody waits for it.

A page acknowledges each image when it has drawn it; only then the next one is sent, the newest. So
no image waits anywhere on its way, and what is on the screen is never older than one round trip.
"""

from __future__ import annotations

import asyncio
import json
import time
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
_MESSAGES_EVERY_S = 0.015  # what comes meanwhile is sent together; half of a page's own rhythm

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


async def receive_messages(socket: WebSocket, post: Post, on_message: OnMessage) -> None:
    """Receive a page's messages; one that sends too much is disconnected."""
    bucket = Bucket(*_TOO_OFTEN)
    while True:
        event = await socket.receive()
        if event["type"] == "websocket.disconnect":
            return
        text = event.get("text")
        if text is None or len(text) > MOST_MESSAGE_BYTES:
            await socket.close(1009, "that is too long.")
            return
        message = _parsed(text)
        if message.get("do") == "seen" and post.acknowledge(message.get("image")):
            continue  # as often as there are images
        if not bucket.take():
            await socket.close(1008, "that is too often.")
            return
        if message.get("do") == "ping":
            await post.send({"type": "pong", "at": message.get("at"), "wall_s": time.time()})
        elif message:
            await on_message(message)


def _parsed(text: str) -> Message:
    """Return a message; an empty one when it makes no sense."""
    try:
        message = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    return message if isinstance(message, dict) else {}


class Post:
    """Deliver an event stream to one page."""

    def __init__(self, socket: WebSocket, stream: EventStream, client: str = "") -> None:
        self._socket = socket
        self._stream = stream
        self._client = client
        self._loop = asyncio.get_running_loop()
        self._news = asyncio.Event()
        self._image_news = asyncio.Event()
        self._sending = asyncio.Lock()  # keeps the order: a story before its image
        self._unseen: int | None = None  # the image that the page has not acknowledged yet
        self._box = Mailbox(self._wake)

    async def send(self, message: Message) -> None:
        """One message, past the stream."""
        await self._out(dumps(message))

    async def deliver(self) -> None:
        """Send all that is published, until the page has gone."""
        self._stream.join(self._box)
        await together(self._deliver_messages(), self._deliver_images())

    def acknowledge(self, image: object) -> bool:
        """Note that the page has drawn an image; return whether that was awaited."""
        if self._unseen is None or image != self._unseen:
            return False
        self._unseen = None
        self._image_news.set()
        return True

    def close(self) -> None:
        """Stop: the page has gone."""
        self._stream.leave(self._box)

    async def _deliver_messages(self) -> None:
        while True:
            await self._news.wait()
            self._news.clear()
            while (mail := self._box.take()) is not None:
                for packed in _packed(mail, self._client):
                    await self._out(packed)
            self._image_news.set()  # it waits for its story
            await asyncio.sleep(_MESSAGES_EVERY_S)

    async def _deliver_images(self) -> None:
        while True:
            await self._image_news.wait()
            self._image_news.clear()
            if self._unseen is None and (picture := self._box.take_picture()) is not None:
                self._unseen = picture[0]["image"]
                await self._out(pack(*picture))

    async def _out(self, packed: str | bytes) -> None:
        # Not by `wait_for`: before Python 3.12 a cancellation amid its end is lost.
        async with self._sending, asyncio.timeout(SEND_S):
            if isinstance(packed, str):
                await self._socket.send_text(packed)
            else:
                await self._socket.send_bytes(packed)

    def _wake(self) -> None:
        with suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(self._set_news)

    def _set_news(self) -> None:
        self._news.set()
        self._image_news.set()


def _packed(mail: Mail, client: str) -> list[str | bytes]:
    found: list[str | bytes] = []
    if mail.story is not None:
        found.append(dumps({"type": "story", "messages": mail.story}))
    found += [dumps(message) for message in mail.messages]
    found += [dumps(as_seen_by(client, message)) for message in mail.newest]
    if mail.strip is not None:
        found.append(mail.strip.packed())
    return found
