"""`/ws`: the messages of the job as they come."""

from __future__ import annotations

from fastapi import WebSocket

from labrig.panel.core.panel import Panel
from labrig.panel.core.sockets import Post, address_of, receive_messages, together
from labrig.panel.live.event_stream import Message
from labrig.panel.server.operation import full_status

MOST_PAGES = 32


async def serve_live(socket: WebSocket, panel: Panel) -> None:
    """One page, until it goes."""
    control = panel.control
    if control.message()["clients"] >= MOST_PAGES:
        await socket.close(1013, "too many pages are open.")
        return
    await socket.accept()
    client = control.arrive(address_of(socket), socket.query_params.get("client", ""))
    status = full_status(panel, socket.headers.get("host", ""), client)
    hello = {"type": "hello", "client": client, "status": status}
    hello |= {key: status[key] for key in ("version", "mode", "stop_url")}
    post = Post(socket, panel.stream, client)
    try:
        await post.send(hello)
        await together(post.deliver(), receive_messages(socket, post, _no_more))
    finally:
        post.close()
        control.leave(client)


async def _no_more(_message: Message) -> None:
    """Ignore messages: a live page asks by HTTP."""
