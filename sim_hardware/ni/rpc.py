"""The call that a handler answers, and the fields that messages share."""

from __future__ import annotations

from typing import Any, Protocol

import grpc

# gRPC and its messages are untyped here: `Message` marks where one is meant.
Message = Any


class Call(Protocol):
    """The call being answered."""

    @property
    def client(self) -> str:
        """The caller: one name for each connection."""

    def is_active(self) -> bool:
        """Return False once the caller has gone or cancelled."""


class CallError(Exception):
    """The call fails with a gRPC status, and perhaps trailing metadata."""

    def __init__(
        self, status: grpc.StatusCode, details: str, trailing: tuple[tuple[str, str], ...] = ()
    ) -> None:
        super().__init__(details)
        self.status = status
        self.details = details
        self.trailing = trailing


def raw_enum(request: Message, field: str) -> int:
    """Return a client's number for an enum; clients send `field_raw`, others `field`."""
    if request.HasField(f"{field}_raw"):
        return int(getattr(request, f"{field}_raw"))
    return int(getattr(request, field))
