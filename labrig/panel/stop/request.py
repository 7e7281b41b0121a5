"""A request to the STOP process: its head, and whether it may be served."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.panel.access.credentials import bearer_of, cookie_of, same_token
from labrig.panel.access.settings import host_name

Refusal = tuple[int, dict[str, str] | None]


@dataclass(frozen=True, kw_only=True)
class StopSettings:
    """What the panel says on our input, as one line of JSON."""

    host: str
    port: int  # wanted; another free one where it is in use
    scheme: str
    panel_port: int
    hosts: tuple[str, ...] | None  # by which we may be called; None: any
    token: str
    data: str
    rig: str | None  # rig.toml's path, where the panel has one
    certificate: str | None
    key: str | None


@dataclass(frozen=True)
class Head:
    """Method, path and headers; names of headers are in lower case."""

    method: str
    path: str
    headers: dict[str, str]

    def origin(self, settings: StopSettings) -> str | None:
        """Return the asking page's origin, when it is the panel's own."""
        host = host_name(self.headers.get("host", "").lower())
        if settings.hosts is not None and host.strip("[]") not in settings.hosts:
            return None
        own = f"{settings.scheme}://{host}:{settings.panel_port}"
        return own if self.headers.get("origin", "").lower() == own else None

    def body_bytes(self, most: int) -> int:
        """Return the size of the body, as far as it is worth reading."""
        stated = self.headers.get("content-length", "0")
        return min(int(stated), most) if stated.isdecimal() else 0


def head_of(raw: bytes) -> Head:
    """Read a request's head. Raises ValueError when it is none."""
    first, *lines = raw.decode("latin-1").rstrip("\r\n").split("\r\n")
    method, path, version = first.split(" ")
    if not version.startswith("HTTP/"):
        raise ValueError("no HTTP request")
    pairs = (line.partition(":") for line in lines)
    return Head(method, path, {name.strip().lower(): value.strip() for name, _, value in pairs})


def refusal_of(head: Head, settings: StopSettings) -> Refusal | None:
    """Return status and sentence for who is not served; None for who shows the token."""
    if head.method == "OPTIONS":  # a browser that asks first whether it may
        return (403 if head.origin(settings) is None else 204), None
    if head.path.partition("?")[0] != "/stop":
        return 404, {"error": "there is only /stop here."}
    if head.method not in {"GET", "POST"}:
        return 405, {"error": "only GET and POST are understood here."}
    if same_token(bearer_of(head.headers), settings.token):
        return None
    if head.origin(settings) is None:
        return 403, {"error": "only the panel's own page may do this."}
    if not same_token(cookie_of(head.headers.get("cookie", "")), settings.token):
        return 401, {"error": "the token is missing or wrong."}
    return None
