"""A panel's server without a rig behind it: says whatever a test has it say, and can hang.

`python -m tests.panel_browser.fake_panel` plays the made-up session, to look at the page.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
import sys
import threading
import time
from pathlib import Path
from typing import Any, Self

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

import labrig.panel
from labrig.panel.pages.interface import listing
from tests.panel_browser import made_up

STATIC = Path(labrig.panel.__file__).parent / "static"
PATIENCE_S = 30.0  # for a page to come


_ports = [0]  # of the panels of this process, the newest first


def _listen() -> socket.socket:
    """Where the one before has listened, if it has ended: the browser keeps that one's scripts."""
    for port in _ports:
        with contextlib.suppress(OSError):
            listening = socket.create_server(("127.0.0.1", port))
            _ports[:] = [listening.getsockname()[1], 0]
            return listening
    raise OSError("no port is free")


class FakePanel:
    """`answers` may be changed: (method, path) -> what is answered. `asked` is what came."""

    def __init__(self, mode: str = "rig") -> None:
        self.mode = mode
        self.asked: list[tuple[str, str, Any]] = []
        self.answers: dict[tuple[str, str], Any] = {}
        self.greeting: list[dict[str, Any] | bytes] = []  # after hello
        self.seen: list[int] = []  # images that a page has acknowledged
        self.ahead_s = 0.0  # of the server's clock before the page's
        self.hangs = False
        self.sockets: set[WebSocket] = set()
        self._greeted = threading.Event()  # a page has come, and was told all there was
        self._heard = threading.Condition()
        self._over = asyncio.Event()  # no request is left hanging
        self.control = {"holder": None, "name": None, "since": None, "here": True, "clients": 1}
        routes = [
            Route("/", lambda _: FileResponse(STATIC / "index.html")),
            Mount("/static", StaticFiles(directory=STATIC)),
            WebSocketRoute("/ws", self._socket),
            Route("/{path:path}", self._http, methods=["GET", "POST", "PUT", "DELETE"]),
        ]
        self.listening = _listen()
        self.port = self.listening.getsockname()[1]
        config = uvicorn.Config(
            Starlette(routes=routes), log_level="error", lifespan="off", ws="websockets-sansio"
        )
        self._server = uvicorn.Server(config)
        self.loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._serve, daemon=True)

    def _serve(self) -> None:
        self.loop.run_until_complete(self._server.serve(sockets=[self.listening]))
        self.loop.close()

    def __enter__(self) -> Self:
        listing(self.mode)  # as in the panel, which loads its pages before it answers
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.loop.call_soon_threadsafe(self._over.set)
        self._server.should_exit = self._server.force_exit = True
        self._thread.join(10)
        self.listening.close()

    @property
    def url(self) -> str:
        """Of the page."""
        return f"http://127.0.0.1:{self.port}/"

    def tell(self, *messages: dict[str, Any] | bytes) -> None:
        """To every page, once there is one: what is told to nobody is never told again."""
        assert self._greeted.wait(PATIENCE_S), "no page has come to be told anything"
        for message in messages:
            asyncio.run_coroutine_threadsafe(self._tell(message), self.loop).result(PATIENCE_S)

    def until_asked(self, *paths: str) -> None:
        """Until a page has acted in all these ways: what it shows may come before its request."""

        def all_came() -> bool:
            return set(paths) <= {path for method, path, _ in self.asked if method != "GET"}

        with self._heard:
            assert self._heard.wait_for(all_came, PATIENCE_S), f"asked: {self.asked}"

    async def _tell(self, message: dict[str, Any] | bytes) -> None:
        for one in list(self.sockets):
            with contextlib.suppress(RuntimeError, WebSocketDisconnect):
                await _send(one, message)

    def status(self) -> dict[str, Any]:
        """As /api/status."""
        return {
            "version": "0", "mode": self.mode, "rig": "rig.toml", "session": None, "data": ".",
            "simulated": True, "model": "model.toml", "job": None, "control": self.control,
            "stop_url": f"{self.url}stop", **listing(self.mode),
        }  # fmt: skip

    async def _socket(self, one: WebSocket) -> None:
        await one.accept()
        client = one.query_params.get("client") or f"c{len(self.asked)}"
        hello = {"type": "hello", "client": client, "version": "0", "mode": self.mode}
        await one.send_json({**hello, "stop_url": f"{self.url}stop", "status": self.status()})
        for message in self.greeting:
            await _send(one, message)
        self.sockets.add(one)
        self._greeted.set()
        try:
            while True:
                asked = await one.receive_json()
                if asked.get("do") == "seen":
                    self.seen.append(asked["image"])
                elif asked.get("do") == "ping" and not self.hangs:
                    now = {"at": asked["at"], "wall_s": time.time() + self.ahead_s}
                    await one.send_json({"type": "pong", **now})
        except WebSocketDisconnect:
            pass
        finally:
            self.sockets.discard(one)
            if not self.sockets:
                self._greeted.clear()

    async def _http(self, request: Request) -> Response:
        path = request.url.path
        raw = await request.body()
        with contextlib.suppress(ValueError):
            raw = await request.json() if raw else None
        with self._heard:
            self.asked.append((request.method, path, raw))
            self._heard.notify_all()
        if self.hangs and path != "/stop":
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._over.wait(), PATIENCE_S)
        if (request.method, path) in self.answers:
            return _answer(self.answers[request.method, path])
        if path == "/api/status":
            return JSONResponse(self.status())
        if path == "/stop":
            return JSONResponse({"output": "safe", "took_s": 0.07, "told": "0 V read back."})
        if path == "/api/control":
            taken = raw["do"] == "take"
            client = request.headers.get("x-labrig-client")
            self.control = {**self.control, "holder": client if taken else None}
            self.control["name"] = raw.get("name") if taken else None
            return JSONResponse(self.control)
        if request.method == "GET":
            return JSONResponse({"error": f"no {path} here."}, 404)
        return JSONResponse({"ok": True, "sent": True, "told": "sent"})


def _answer(found: Any) -> Response:
    status, body = found if isinstance(found, tuple) else (200, found)
    if isinstance(body, bytes):
        return Response(body, status, media_type="image/png")
    return JSONResponse(body, status)


async def _send(one: WebSocket, message: dict[str, Any] | bytes) -> None:
    if isinstance(message, bytes):
        await one.send_bytes(message)
    else:
        await one.send_json(message)


def picture_frame(
    number: int, volts: float, time_s: float = 0.0, exposed_s: float | None = None
) -> bytes:
    """As a binary frame."""
    header = {"type": "picture", "frame": number, "image": number, "time_s": time_s, "run": 4}
    more = {"exposed_s": exposed_s, "width": 640, "height": 480, "mime": "image/jpeg"}
    return made_up.binary({**header, **more}, made_up.picture(volts, number))


def curve(number: int, volts: float) -> dict[str, Any]:
    """Of a picture, and a model that is somewhat off."""
    model = {"points_px": made_up.curve_px(volts * 0.85), "voltage_V": volts, "force_mN": 1.0}
    model |= {"distance_mm": 0.3123, "force_error_mN": -0.1449}
    return {
        "type": "curve", "frame": number, "run": 4, "ok": True, "why": "",
        "points_px": made_up.curve_px(volts), "covered": 1.0, "tip_mm": [40, 10],
        "model": {**model, "why": ""},
    }  # fmt: skip


def greeting() -> list[dict[str, Any] | bytes]:
    """All that a page is told that comes in the middle of run 5."""
    return [
        {"type": "story", "messages": made_up.story()},
        made_up.signals(4, -0.2, 12.9, fresh=True),
        picture_frame(300, 2.0, 313.9),
        curve(300, 2.0),
        made_up.predicted(4, 0.0, 12.9, fresh=True),
        made_up.motion(300, 2.0),
        made_up.estimates(),
    ]


if __name__ == "__main__":
    with FakePanel() as panel:
        panel.greeting = greeting()
        print(panel.url, flush=True)
        sys.stdin.read()
