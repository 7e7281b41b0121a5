"""One form for everything that is sent: a JSON header, and bytes behind it.

`u32 n`, `n` bytes of JSON padded with spaces so that what follows is aligned to 8 bytes, payload.
Between processes each of these has its whole length before it, once more as `u32`.
"""

from __future__ import annotations

import json
import socket
import struct
from typing import IO, Any

from labrig.serialise import finite

Header = dict[str, Any]

MOST_BYTES = 64 << 20  # a picture of 16384 x 2000 in 16 bit
_U32 = struct.Struct("<I")


class BrokenConnectionError(Exception):
    """The other side has gone, or sends what it should not."""


def pack(header: Header, payload: bytes | memoryview = b"") -> bytes:
    """Header and payload as one."""
    text = dumps(header).encode("utf-8")
    text += b" " * (-(4 + len(text)) % 8)
    return b"".join((_U32.pack(len(text)), text, payload))


def unpack(packed: bytes) -> tuple[Header, memoryview]:
    """Return the reverse of `pack`. Raises BrokenConnectionError."""
    if len(packed) < 4:
        raise BrokenConnectionError("a message is shorter than its own beginning")
    end = 4 + _U32.unpack_from(packed)[0]
    if end > len(packed):
        raise BrokenConnectionError("a message is shorter than it says")
    try:
        header = json.loads(packed[4:end])
    except (ValueError, RecursionError) as error:
        raise BrokenConnectionError(f"a message cannot be read: {error}") from None
    if not isinstance(header, dict):
        raise BrokenConnectionError("a message is no object")
    return header, memoryview(packed)[end:]


def dumps(value: Any) -> str:
    """JSON without what JSON does not have: NaN and infinities become null."""
    try:
        return json.dumps(value, allow_nan=False, separators=(",", ":"))
    except ValueError:
        return json.dumps(finite(value), allow_nan=False, separators=(",", ":"))


def send(connection: socket.socket, packed: bytes) -> None:
    """Send one message. Raises OSError."""
    connection.sendall(_U32.pack(len(packed)) + packed)


def receive(connection: socket.socket, most_bytes: int = MOST_BYTES) -> tuple[Header, memoryview]:
    """Return the next message. Raises BrokenConnectionError at the end, OSError or TimeoutError."""
    size = _U32.unpack(_exactly(connection, 4))[0]
    if size > most_bytes:
        raise BrokenConnectionError(f"a message of {size} bytes is more than {most_bytes}")
    return unpack(_exactly(connection, size))


def write(pipe: IO[bytes], packed: bytes) -> None:
    """Write one message. Raises OSError."""
    pipe.write(_U32.pack(len(packed)) + packed)
    pipe.flush()


def read(pipe: IO[bytes]) -> tuple[Header, memoryview]:
    """Return the next message. Raises BrokenConnectionError at the end, OSError."""
    begin = pipe.read(4)
    size = _U32.unpack(begin)[0] if len(begin) == 4 else 0
    packed = pipe.read(min(size, MOST_BYTES))
    if not size or len(packed) != size:
        raise BrokenConnectionError("the other side has gone")
    return unpack(packed)


def _exactly(connection: socket.socket, size: int) -> bytes:
    parts = bytearray()
    while len(parts) < size:
        part = connection.recv(min(size - len(parts), 1 << 20))
        if not part:
            raise BrokenConnectionError("the other side has gone")
        parts += part
    return bytes(parts)
