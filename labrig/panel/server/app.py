"""The panel's web server."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from fastapi import FastAPI, Request, WebSocket
from fastapi.exceptions import RequestValidationError
from fastapi.responses import FileResponse, JSONResponse, RedirectResponse, Response
from fastapi.staticfiles import StaticFiles
from starlette.exceptions import HTTPException

from labrig.errors import LabrigError
from labrig.panel.pages import calibration as routes_calibration
from labrig.panel.pages import files as routes_files
from labrig.panel.pages import library as routes_library
from labrig.panel.pages import run as routes_run
from labrig.panel.pages.replay_socket import serve_replay
from labrig.panel.pages.sockets import serve_live
from labrig.panel.server.access_control import AccessControl
from labrig.panel.server.credentials import same_token
from labrig.panel.server.errors import status_of
from labrig.panel.server.panel import Panel
from labrig.panel.server.settings import COOKIE, PanelSettings
from model import ModelError

STATIC = Path(__file__).parents[1] / "static"
ROUTERS = (routes_run.router, routes_files.router, routes_calibration.router, routes_library.router)


def create_app(panel: Panel) -> FastAPI:
    """The server's application. Nothing is served to who does not pass the gate."""

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        app.state.panel = panel
        yield

    app = FastAPI(
        title="labrig", docs_url=None, redoc_url=None, openapi_url=None, lifespan=lifespan
    )
    for router in ROUTERS:
        app.include_router(router)
    _pages(app, panel.settings)
    _answers_in_sentences(app)
    app.add_middleware(AccessControl, settings=panel.settings)
    return app


def _pages(app: FastAPI, settings: PanelSettings) -> None:
    @app.get("/")
    def page(token: str | None = None) -> Response:
        if token is None:
            return FileResponse(STATIC / "index.html")
        if not same_token(token, settings.token):
            sentence = "the token is wrong; use the address labrig has printed last."
            return JSONResponse({"error": sentence}, 401)
        answer = RedirectResponse("/", 303)
        secure = settings.scheme == "https"
        answer.set_cookie(COOKIE, token, httponly=True, samesite="strict", secure=secure)
        return answer

    @app.websocket("/ws")
    async def live(socket: WebSocket) -> None:
        await serve_live(socket, socket.app.state.panel)

    @app.websocket("/ws/replay")
    async def replay(socket: WebSocket, session: str) -> None:
        await serve_replay(socket, socket.app.state.panel, session)

    app.mount("/static", StaticFiles(directory=STATIC), name="static")


def _answers_in_sentences(app: FastAPI) -> None:
    @app.exception_handler(LabrigError)
    async def refused(_request: Request, error: LabrigError) -> JSONResponse:
        return JSONResponse({"error": str(error)}, status_of(error))

    @app.exception_handler(ModelError)
    async def no_model(_request: Request, error: ModelError) -> JSONResponse:
        return JSONResponse({"error": f"{error}."}, 400)

    @app.exception_handler(RequestValidationError)
    async def not_understood(_request: Request, error: RequestValidationError) -> JSONResponse:
        told = "; ".join(_fault(fault) for fault in error.errors()[:5])
        return JSONResponse({"error": f"what was sent is wrong: {told}."}, 400)

    @app.exception_handler(HTTPException)
    async def other(_request: Request, error: HTTPException) -> JSONResponse:
        sentence = "there is no such thing." if error.status_code == 404 else f"{error.detail}."
        return JSONResponse({"error": sentence}, error.status_code)


def _fault(fault: dict[str, Any]) -> str:
    where = ".".join(str(part) for part in fault["loc"] if part != "body") or "the body"
    return f"{where}: {str(fault['msg'])[:120]}"
