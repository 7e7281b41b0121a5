"""Records of an append-only file: numbered and checksummed, so that a torn end is recognised.

A record is

    magic, number, length of head, length of blob | CRC-32 of all the rest | head | blob

with the head a JSON object and the blob raw bytes.
"""

from __future__ import annotations

import json
import os
import struct
import zlib
from collections.abc import Iterator
from typing import Any, BinaryIO

Record = tuple[dict[str, Any], bytes]

_MAGIC = b"LRJ1"
_FIXED = struct.Struct("<4sQIQ")
_CRC = struct.Struct("<I")
_LONGEST_HEAD = 1 << 28


def packed(number: int, head: dict[str, Any], blob: bytes) -> bytes:
    """Return a record's bytes."""
    text = json.dumps(head).encode("utf-8")
    fixed = _FIXED.pack(_MAGIC, number, len(text), len(blob))
    crc = zlib.crc32(blob, zlib.crc32(text, zlib.crc32(fixed)))
    return b"".join((fixed, _CRC.pack(crc), text, blob))


def write_all(file: BinaryIO, data: bytes) -> None:
    """Write to an unbuffered file, which may take less than it is given at a time."""
    view = memoryview(data)
    while view:
        view = view[file.write(view) :]


def records(file: BinaryIO, first: int) -> Iterator[Record]:
    """Yield records numbered from `first`; leave the file at the end of the last whole one."""
    number = first
    size = os.fstat(file.fileno()).st_size
    while True:
        begin = file.tell()
        record = _record(file, number, size)
        if record is None:
            file.seek(begin)
            return
        yield record
        number += 1


def _record(file: BinaryIO, number: int, size: int) -> Record | None:
    fixed = file.read(_FIXED.size)
    wanted = file.read(_CRC.size)
    if len(fixed) < _FIXED.size or len(wanted) < _CRC.size:
        return None
    magic, found, head_length, blob_length = _FIXED.unpack(fixed)
    if magic != _MAGIC or found != number or head_length > _LONGEST_HEAD:
        return None
    if head_length + blob_length > size - file.tell():
        return None
    text, blob = file.read(head_length), file.read(blob_length)
    if zlib.crc32(blob, zlib.crc32(text, zlib.crc32(fixed))) != _CRC.unpack(wanted)[0]:
        return None
    try:
        head = json.loads(text)
    except (ValueError, RecursionError):
        return None
    return (head, blob) if isinstance(head, dict) else None
