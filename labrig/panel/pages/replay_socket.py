"""`/ws/replay`: a recorded session, played for one page."""

from __future__ import annotations

import asyncio

from fastapi import WebSocket

from labrig.errors import LabrigError
from labrig.panel.live.event_stream import Message
from labrig.panel.pages.file_names import existing
from labrig.panel.pages.sockets import Post, hear, together
from labrig.panel.replay import Player
from labrig.panel.server.panel import Panel

MOST_REPLAYS = 4  # each with a process that looks for the curve
SUFFIX = ".h5"


async def serve_replay(socket: WebSocket, panel: Panel, name: str) -> None:
    """One page's replay, until it goes."""
    await socket.accept()
    if panel.replays >= MOST_REPLAYS:
        await socket.close(1013, f"{MOST_REPLAYS} replays are open; close one of them.")
        return
    panel.replays += 1
    try:
        await _play(socket, panel, name)
    except LabrigError as error:
        await socket.send_json({"type": "error", "error": str(error)})
        await socket.close(1008, "this session cannot be replayed.")
    finally:
        panel.replays -= 1


async def _play(socket: WebSocket, panel: Panel, name: str) -> None:
    path = existing(panel.settings.data, name, SUFFIX)
    player = await asyncio.to_thread(Player, path, name, panel.model_path)

    async def heard(word: Message) -> None:
        player.do(word)

    post = Post(socket, player.feed)
    status = panel.status(socket.headers.get("host", ""), "")
    hello = {"type": "hello", "client": None, "status": status}
    try:
        await post.send({**hello, "version": status["version"], "mode": "replay", "stop_url": None})
        await post.send(player.first())
        await together(post.deliver(), hear(socket, heard))
    finally:
        post.close()
        await asyncio.to_thread(player.close)
