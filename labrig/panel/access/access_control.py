"""Access control: each request is checked before anything else sees it."""

from __future__ import annotations

import json
from contextlib import suppress
from urllib.parse import parse_qs

from starlette.requests import ClientDisconnect
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from labrig.panel.access.bodies import RequestBody, body_limit
from labrig.panel.access.credentials import bearer_of, cookie_of, same_token
from labrig.panel.access.rate_limits import Bucket, Buckets
from labrig.panel.access.settings import PanelSettings, host_name

STOP_PATH = "/api/stop"  # no press of who has the token is one too many
_PUBLIC = ("/static/", "/favicon.ico")
_IDENTIFIED = (120.0, 600.0)  # requests of who has the token: in a second, at once


class _RefusedError(Exception):
    def __init__(self, status: int, text: str) -> None:
        super().__init__(text)
        self.status = status


class _TooLargeError(_RefusedError):
    def __init__(self, most_bytes: int) -> None:
        super().__init__(413, f"more than {most_bytes >> 10} kB are not accepted.")


class _TooOftenError(_RefusedError):
    def __init__(self) -> None:
        super().__init__(429, "that is too often; wait a second.")


class AccessControl:
    """ASGI middleware: host, origin, token, size and rate.

    `unidentified`: the budgets of addresses without the token, which connections know, too.
    """

    def __init__(self, app: ASGIApp, settings: PanelSettings, unidentified: Buckets) -> None:
        self._app = app
        self._settings = settings
        self._identified = Bucket(*_IDENTIFIED)
        self._unidentified = unidentified

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """See ASGI."""
        if scope["type"] not in {"http", "websocket"}:
            await self._app(scope, receive, send)
            return
        headers = {
            name.decode("latin-1"): value.decode("latin-1") for name, value in scope["headers"]
        }
        body = RequestBody(receive, body_limit(scope.get("path", "")))
        try:
            self._check(scope, headers)
            if scope["type"] == "websocket":
                await self._app(scope, receive, send)
            else:
                await self._serve(scope, headers, body, send)
        except _RefusedError as refused:
            if scope["type"] == "websocket":
                await _refuse_socket(receive, send, refused)
            else:
                await _refuse(body, send, refused)

    async def _serve(
        self, scope: Scope, headers: dict[str, str], body: RequestBody, send: Send
    ) -> None:
        stated = headers.get("content-length", "0")
        if not stated.isdigit() or int(stated) > body.most_bytes:
            raise _TooLargeError(body.most_bytes)
        answered = False
        more = self._more_headers(headers)

        async def send_with(message: Message) -> None:
            nonlocal answered
            if body.too_large and not answered:
                return  # an answer to half a body; the refusal says why it is half
            if message["type"] == "http.response.start":
                answered = True
                message["headers"] = [*message.get("headers", []), *more]
            await send(message)

        with suppress(ClientDisconnect):
            await self._app(scope, body.take, send_with)
        if body.too_large and not answered:
            raise _TooLargeError(body.most_bytes)

    def _check(self, scope: Scope, headers: dict[str, str]) -> None:
        """Refuse who may not come in. Each refusal counts for its address alone."""
        try:
            identified = self._is_identified(scope, headers)
        except _RefusedError:
            self._count_unidentified(scope)
            raise
        if not identified:
            self._count_unidentified(scope)
        elif scope["path"] != STOP_PATH and not self._identified.take():
            raise _TooOftenError

    def _count_unidentified(self, scope: Scope) -> None:
        address = (scope.get("client") or ("unknown", 0))[0]
        if not self._unidentified.take(address):
            raise _TooOftenError

    def _is_identified(self, scope: Scope, headers: dict[str, str]) -> bool:
        """Whether the token is there. Raises _RefusedError where it is needed, or wrongly used."""
        host = headers.get("host", "").lower()
        names = self._settings.names
        if names is not None and host not in names:
            raise _RefusedError(403, f"this panel is not called {host!r}.")
        with_bearer = same_token(bearer_of(headers), self._settings.token)
        self._check_origin(scope, headers, host, with_bearer)
        if with_bearer or same_token(cookie_of(headers.get("cookie", "")), self._settings.token):
            return True
        if scope["path"] == "/":
            return same_token(_token_of_address(scope), self._settings.token)
        if scope["path"].startswith(_PUBLIC):
            return False
        raise _RefusedError(401, "the token is missing or wrong; use the address labrig printed.")

    def _check_origin(
        self, scope: Scope, headers: dict[str, str], host: str, with_bearer: bool
    ) -> None:
        """Check the page that asks, which a browser names; a bearer token comes from no browser."""
        origin = headers.get("origin")
        if origin is not None and origin.lower() != f"{self._settings.scheme}://{host}":
            raise _RefusedError(403, f"a page of {origin} may not use this panel.")
        reads = scope["type"] == "http" and scope["method"] in {"GET", "HEAD"}
        if origin is None and not reads and not with_bearer:
            raise _RefusedError(403, "a request that does not say where it comes from may not act.")

    def _more_headers(self, headers: dict[str, str]) -> list[tuple[bytes, bytes]]:
        settings = self._settings
        host = headers.get("host", "")
        stop = settings.url("", port=settings.stop_port, name=host_name(host))
        sockets = f"{'ws' if settings.scheme == 'http' else 'wss'}://{host}"
        policy = (
            "default-src 'self'; script-src 'self'; style-src 'self' 'unsafe-inline'; "
            f"img-src 'self' blob: data:; connect-src 'self' {sockets} {stop}; object-src 'none'; "
            "base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
        )
        return [
            (b"content-security-policy", policy.encode("latin-1", "replace")),
            (b"x-content-type-options", b"nosniff"),
            # not no-referrer: a form without a script would not say where it comes from
            (b"referrer-policy", b"same-origin"),
            (b"cache-control", b"no-store"),
        ]


def _token_of_address(scope: Scope) -> str:
    """Return the token of the printed address."""
    query: bytes = scope.get("query_string", b"")
    return parse_qs(query.decode("latin-1")).get("token", [""])[0]


async def _refuse(body: RequestBody, send: Send, refused: _RefusedError) -> None:
    content = json.dumps({"error": str(refused)}).encode()
    headers = [
        (b"content-type", b"application/json"),
        (b"content-length", str(len(content)).encode()),
        (b"connection", b"close"),
    ]
    await send({"type": "http.response.start", "status": refused.status, "headers": headers})
    await send({"type": "http.response.body", "body": content, "more_body": True})
    await body.drain()
    await send({"type": "http.response.body", "body": b""})


async def _refuse_socket(receive: Receive, send: Send, refused: _RefusedError) -> None:
    await receive()
    await send({"type": "websocket.close", "code": 1008, "reason": str(refused)})
