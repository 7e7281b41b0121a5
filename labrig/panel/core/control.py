"""One client holds control, the others watch."""

from __future__ import annotations

import datetime as dt
import hashlib
import re
import secrets
import threading
from collections.abc import Callable
from dataclasses import dataclass

from labrig.panel.errors import ForbiddenError
from labrig.panel.live.event_stream import Message

_MOST_NAME = 40
_NAME = re.compile(r"[A-Za-z0-9_-]{16}")


@dataclass(frozen=True)
class Holder:
    """Who holds control."""

    client: str
    name: str
    since: str


def utc_now() -> str:
    """Return the time of day, ISO 8601, UTC."""
    return dt.datetime.now(dt.UTC).isoformat(timespec="seconds")


def public_name(client: str) -> str:
    """Return what others may know of a page: with its name itself they could act in its place."""
    return hashlib.sha256(client.encode("utf-8", "replace")).hexdigest()[:16]


def as_seen_by(client: str, message: Message) -> Message:
    """Return a `control` message for one page: it recognises itself, and nobody else."""
    if message.get("type") == "control" and client and message["holder"] == public_name(client):
        return {**message, "holder": client}
    return message


class Control:
    """Clients are pages with an open socket. `on_change` is called after each change."""

    def __init__(self, on_change: Callable[[Message], None]) -> None:
        self._on_change = on_change
        self._lock = threading.Lock()
        self._clients: dict[str, str] = {}  # name of a page -> its address
        self._holder: Holder | None = None

    def arrive(self, address: str, known_as: str = "") -> str:
        """Return a page has opened its socket; the name it is to give when it acts.

        One that was here before, and was loaded again, keeps its name and with it control.
        """
        with self._lock:
            again = _NAME.fullmatch(known_as) is not None and known_as not in self._clients
            client = known_as if again else secrets.token_urlsafe(12)
            self._clients[client] = address
        self._on_change(self.message())
        return client

    def leave(self, client: str) -> None:
        """Its socket is closed. Control stays in its hands until somebody takes it."""
        with self._lock:
            self._clients.pop(client, None)
        self._on_change(self.message())

    def take(self, client: str, name: str, *, force: bool) -> Holder:
        """Take control; from somebody who is there only with `force`. Raises ForbiddenError."""
        with self._lock:
            address = self._address(client)
            holder = self._holder
            others = holder is not None and holder.client != client
            if others and holder is not None and holder.client in self._clients and not force:
                raise ForbiddenError(f"{holder.name} holds control since {holder.since}.")
            shown = " ".join(name.split())[:_MOST_NAME] or "somebody"
            self._holder = Holder(client, f"{shown} ({address})", utc_now())
            new_holder = self._holder
        self._on_change(self.message())
        return new_holder

    def release(self, client: str) -> None:
        """Give it back. Raises ForbiddenError for who does not hold it."""
        self.require(client)
        with self._lock:
            self._holder = None
        self._on_change(self.message())

    def require(self, client: str) -> str:
        """Who acts, when they may. Raises ForbiddenError."""
        with self._lock:
            self._address(client)
            if self._holder is None:
                raise ForbiddenError("nobody holds control; take it first.")
            if self._holder.client != client:
                raise ForbiddenError(f"{self._holder.name} holds control; take it, or watch.")
            return self._holder.name

    def who(self, client: str, address: str) -> str:
        """Who somebody is that needs no control: for STOP."""
        with self._lock:
            if self._holder is not None and self._holder.client == client:
                return self._holder.name
        return f"somebody at {address}"

    def message(self) -> Message:
        """Return the message for pages."""
        with self._lock:
            holder = self._holder
            return {
                "type": "control",
                "holder": None if holder is None else public_name(holder.client),
                "name": None if holder is None else holder.name,
                "since": None if holder is None else holder.since,
                "here": holder is not None and holder.client in self._clients,
                "clients": len(self._clients),
            }

    def message_for(self, client: str) -> Message:
        """Return the message for one page: it knows its own name, all others stay secret."""
        return as_seen_by(client, self.message())

    def _address(self, client: str) -> str:
        if client not in self._clients:
            raise ForbiddenError("this page is not connected; load it again.")
        return self._clients[client]
