"""What a panel is started with, and the names by which it is spoken to."""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

DEFAULT_PORT = 8720
COOKIE = "labrig_token"
LOOPBACK = frozenset({"127.0.0.1", "localhost", "::1"})
ANYWHERE = frozenset({"0.0.0.0", "::", ""})  # noqa: S104 - compared with, not bound to


@dataclass(frozen=True, kw_only=True)
class PanelSettings:
    """Paths are whole ones."""

    data: Path  # no file outside this folder can be named
    rig: Path | None = None
    session: Path | None = None  # to be replayed
    model: Path | None = None
    photographs: bool = False  # `data` is a folder of photographs, and nothing else is shown
    host: str = "127.0.0.1"
    port: int = DEFAULT_PORT  # as bound
    certificate: Path | None = None
    key: Path | None = None
    stop_port: int = 0  # of the STOP process; 0: there is none
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24))

    @property
    def mode(self) -> Literal["rig", "sessions", "replay", "photographs"]:
        """What the page begins with."""
        if self.photographs:
            return "photographs"
        if self.rig is not None:
            return "rig"
        return "sessions" if self.session is None else "replay"

    @property
    def scheme(self) -> str:
        """How we are spoken to: with TLS where there is a certificate."""
        return "http" if self.certificate is None else "https"

    @property
    def names(self) -> frozenset[str] | None:
        """`Host` headers that are ours; None: any, as we may be reached by any name."""
        if self.host in ANYWHERE:
            return None
        hosts = LOOPBACK if self.host in LOOPBACK else frozenset({self.host})
        return frozenset(f"{_bracketed(host)}:{self.port}" for host in hosts)

    def url(self, path: str = "/", *, port: int | None = None, name: str | None = None) -> str:
        """Return an address of ours; `name`: the host by which the asker reached us."""
        host = name or ("127.0.0.1" if self.host in ANYWHERE else self.host)
        return f"{self.scheme}://{_bracketed(host)}:{self.port if port is None else port}{path}"


def _bracketed(host: str) -> str:
    return f"[{host}]" if ":" in host and not host.startswith("[") else host


def host_name(host_header: str) -> str:
    """Return the name within a `Host` header, without its port."""
    name, _, port = host_header.rpartition(":")
    return name if port.isdigit() and name else host_header
