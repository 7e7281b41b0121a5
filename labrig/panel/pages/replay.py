"""The page that replays a recorded session: `/ws/replay`, a player for each page."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass

from fastapi import APIRouter, WebSocket

from labrig.errors import LabrigError
from labrig.files import SESSION_ENDINGS
from labrig.panel.core.file_names import existing
from labrig.panel.core.panel import Panel
from labrig.panel.core.requests import Here
from labrig.panel.core.sockets import Post, receive_messages, together
from labrig.panel.live.event_stream import Message
from labrig.panel.pages.interface import NOWHERE, PanelPage, own_script
from labrig.panel.replay import Player

MOST_REPLAYS = 4  # each with a curve process
router = APIRouter()


@dataclass
class OpenReplays:
    """How many pages replay a session now."""

    count: int = 0


@router.websocket("/ws/replay")
async def replay(socket: WebSocket, panel: Here, session: str) -> None:
    """Play a session for one page, until it closes."""
    await serve_replay(socket, panel, session)


async def serve_replay(socket: WebSocket, panel: Panel, name: str) -> None:
    """One page's replay, until it goes."""
    await socket.accept()
    replays = panel.state(OpenReplays)
    if replays.count >= MOST_REPLAYS:
        await socket.close(1013, f"{MOST_REPLAYS} replays are open; close one of them.")
        return
    replays.count += 1
    try:
        await _play(socket, panel, name)
    except LabrigError as error:
        await socket.send_json({"type": "error", "error": str(error)})
        await socket.close(1008, "this session cannot be replayed.")
    finally:
        replays.count -= 1


async def _play(socket: WebSocket, panel: Panel, name: str) -> None:
    path = existing(panel.settings.data, name, *SESSION_ENDINGS)
    player = await asyncio.to_thread(Player, path, name, panel.model_path)

    async def on_message(command: Message) -> None:
        player.do(command)

    post = Post(socket, player.stream)
    status = panel.status(socket.headers.get("host", ""), "")
    hello = {"type": "hello", "client": None, "status": status}
    try:
        await post.send({**hello, "version": status["version"], "mode": "replay", "stop_url": None})
        await post.send(player.first())
        await together(post.deliver(), receive_messages(socket, post, on_message))
    finally:
        post.close()
        await asyncio.to_thread(player.close)


PAGE = PanelPage(
    title="Replay",
    order=53,
    modes=NOWHERE,
    opens=frozenset({"replay"}),
    router=router,
    script=own_script("replay"),
)
