"""A page that goes while the panel does."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import uvicorn
from uvicorn.server import ServerState
from websockets.client import ClientProtocol
from websockets.uri import parse_uri

from labrig.panel.server.connection import PageConnection


class FullTransport:
    """Keeps what was written before: closing takes its time."""

    closed = 0

    def __init__(self) -> None:
        self.sent = b""

    def get_extra_info(self, _name: str) -> Any:
        return None

    def write(self, data: bytes) -> None:
        self.sent += data

    def close(self) -> None:
        self.closed += 1

    def is_closing(self) -> bool:
        return self.closed > 0

    def pause_reading(self) -> None: ...

    def resume_reading(self) -> None: ...


async def accepts(_scope: Any, receive: Any, send: Any) -> None:
    """A page is let in, and heard until it goes."""
    await receive()
    await send({"type": "websocket.accept"})
    while (await receive())["type"] != "websocket.disconnect":
        pass


async def close_while_it_goes() -> tuple[FullTransport, ServerState]:
    state, transport = ServerState(), FullTransport()
    config = uvicorn.Config(accepts, ws=PageConnection, log_level="error")
    config.load()
    connection = PageConnection(config, state, {}, asyncio.get_running_loop())
    connection.connection_made(transport)  # type: ignore[arg-type]
    page = ClientProtocol(parse_uri("ws://127.0.0.1/ws"))
    page.send_request(page.connect())
    connection.data_received(b"".join(page.data_to_send()))
    await asyncio.sleep(0.01)
    page.receive_data(transport.sent)
    page.send_close(1001)
    connection.data_received(b"".join(page.data_to_send()))
    await asyncio.sleep(0.01)
    assert transport.closed  # but what was written before has not been taken yet
    transport.closed = 0
    connection.shutdown()
    return transport, state


def test_a_page_that_is_going_does_not_keep_the_panel_from_ending() -> None:
    # in a thread of its own: other tests' browsers keep a loop in this one
    with ThreadPoolExecutor(1) as apart:
        transport, state = apart.submit(lambda: asyncio.run(close_while_it_goes())).result()
    assert transport.closed
    assert not state.tasks
