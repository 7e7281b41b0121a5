"""What program and watch say to each other: a greeting that proves a shared secret, then frames.

Each end proves by a keyed hash (HMAC-SHA256) that it has the token, which is never sent. Each frame
carries a hash over its number, so that none can be made up or sent again.
"""

from __future__ import annotations

import hashlib
import hmac
import json
import math
import socket
import struct
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from drivers.interfaces import DeviceError

PORT = 31764
ALIVE, REPORT = b"a", b"r"  # from the watch
_HEAD = struct.Struct(">cIH")  # kind, number, length of what follows
_HASH_BYTES = 16
_LONGEST_LINE = 4096
_SHORTEST_TOKEN = 16
VERSION = 1


class NotProvenError(DeviceError):
    """The other end does not have the token, or is no watch."""


def read_token(path: Path) -> bytes:
    """Return the secret in a file. Raises DeviceError."""
    try:
        text = path.read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError) as fault:
        raise DeviceError(f"the watch's token {path} cannot be read: {fault}") from fault
    if len(text) < _SHORTEST_TOKEN:
        raise DeviceError(
            f"the watch's token {path} has fewer than {_SHORTEST_TOKEN} characters; copy the file "
            "that `labrig watch` has made"
        )
    return text.encode("utf-8")


def proof(token: bytes, who: str, *parts: str) -> str:
    """Return what only somebody with the token can compute."""
    text = "\n".join((who, *parts)).encode("utf-8")
    return hmac.new(token, text, hashlib.sha256).hexdigest()


def is_proof(given: object, wanted: str) -> bool:
    """Whether a proof is right; takes as long for a wrong one."""
    return isinstance(given, str) and hmac.compare_digest(given.encode(), wanted.encode())


def session_key(token: bytes, *nonces: str) -> bytes:
    """Return the key of one connection's frames."""
    return bytes.fromhex(proof(token, "frames", *nonces))


def send_line(line: socket.socket, message: Mapping[str, Any]) -> None:
    """Send a line of JSON. Raises OSError."""
    line.sendall(json.dumps(message, sort_keys=True).encode("utf-8") + b"\n")


def read_line(line: socket.socket, within_s: float = math.inf) -> dict[str, Any]:
    """Return a line of JSON; empty: the end, nonsense, or not all of it in time. Raises OSError."""
    data, until_s = b"", time.monotonic() + within_s
    while not data.endswith(b"\n"):
        if time.monotonic() > until_s:  # a byte now and then would keep the connection for ever
            return {}
        byte = line.recv(1)
        if not byte or len(data) > _LONGEST_LINE:
            return {}
        data += byte
    with suppress(ValueError):
        message = json.loads(data)
        if isinstance(message, dict):
            return message
    return {}


class Frames:
    """One direction of a connection."""

    def __init__(self, line: socket.socket, key: bytes, way: str) -> None:
        """`way`: the direction, which is hashed too: no frame can be sent back."""
        self._line = line
        self._key = key + way.encode("utf-8")
        self._number = 0
        self._come = b""  # of a frame that has not come as a whole: a read may time out in it

    def send(self, kind: bytes, text: str = "") -> None:
        """Send a frame. Raises OSError."""
        data = text.encode("utf-8")
        body = _HEAD.pack(kind, self._number, len(data)) + data
        self._number += 1
        self._line.sendall(body + self._hash(body))

    def read(self) -> tuple[bytes, str] | None:
        """Return the next frame; None: the end, or one that is not the other end's. OSError."""
        if not self._have(_HEAD.size):
            return None
        kind, number, length = _HEAD.unpack_from(self._come)
        whole = _HEAD.size + length
        if not self._have(whole + _HASH_BYTES) or number != self._number:
            return None
        body, given = self._come[:whole], self._come[whole:]
        self._come = b""
        if not hmac.compare_digest(self._hash(body), given):
            return None
        self._number += 1
        return kind, body[_HEAD.size :].decode("utf-8", errors="replace")

    def _hash(self, body: bytes) -> bytes:
        return hmac.new(self._key, body, hashlib.sha256).digest()[:_HASH_BYTES]

    def _have(self, count: int) -> bool:
        """Wait until so many bytes of the frame have come; False: the end."""
        while len(self._come) < count:
            piece = self._line.recv(count - len(self._come))
            if not piece:
                return False
            self._come += piece
        return True
