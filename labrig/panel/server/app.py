"""The panel's web server."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from fastapi import FastAPI, Request, WebSocket
from fastapi.exceptions import RequestValidationError
from fastapi.responses import FileResponse, JSONResponse, RedirectResponse, Response
from fastapi.staticfiles import StaticFiles
from starlette.exceptions import HTTPException

from labrig.errors import LabrigError
from labrig.panel.access.access_control import AccessControl
from labrig.panel.access.credentials import same_token
from labrig.panel.access.rate_limits import Buckets
from labrig.panel.access.settings import COOKIE, PanelSettings
from labrig.panel.core.panel import Panel
from labrig.panel.errors import status_of
from labrig.panel.pages.interface import STATIC
from labrig.panel.server import analysis
from labrig.panel.server.live_socket import serve_live
from labrig.panel.server.operation import router
from labrig.panel.server.page_routes import add_page_routes
from model import ModelError


def create_app(panel: Panel, unidentified: Buckets) -> FastAPI:
    """Return the server's application. Access control sees each request before anything else.

    `unidentified`: how often an address may ask without the token.
    """

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        app.state.panel = panel
        yield

    app = FastAPI(
        title="labrig", docs_url=None, redoc_url=None, openapi_url=None, lifespan=lifespan
    )
    app.include_router(router)
    app.include_router(analysis.router)
    add_page_routes(app)
    _entrance(app, panel.settings)
    _answers_in_sentences(app)
    app.add_middleware(AccessControl, settings=panel.settings, unidentified=unidentified)
    return app


def _entrance(app: FastAPI, settings: PanelSettings) -> None:
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
        faults = "; ".join(_fault(fault) for fault in error.errors()[:5])
        return JSONResponse({"error": f"what was sent is wrong: {faults}."}, 400)

    @app.exception_handler(HTTPException)
    async def other(_request: Request, error: HTTPException) -> JSONResponse:
        sentence = "there is no such thing." if error.status_code == 404 else f"{error.detail}."
        return JSONResponse({"error": sentence}, error.status_code)


def _fault(fault: dict[str, Any]) -> str:
    where = ".".join(str(part) for part in fault["loc"] if part != "body") or "the body"
    return f"{where}: {str(fault['msg'])[:120]}"
