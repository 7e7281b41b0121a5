"""Journals with right checksums around wrong content."""

from __future__ import annotations

import json
import struct
import zlib
from pathlib import Path
from typing import Any

_FIXED = struct.Struct("<4sQIQ")
_CRC = struct.Struct("<I")


def records(raw: bytes) -> list[tuple[dict[str, Any], bytes]]:
    """Head and blob of each record."""
    found, at = [], 0
    while at < len(raw):
        _, _, head, blob = _FIXED.unpack_from(raw, at)
        at += _FIXED.size + _CRC.size
        found.append((json.loads(raw[at : at + head]), raw[at + head : at + head + blob]))
        at += head + blob
    return found


def written(parts: list[tuple[dict[str, Any], bytes]]) -> bytes:
    """A journal of these records."""
    out = []
    for number, (head, blob) in enumerate(parts):
        text = json.dumps(head).encode()
        fixed = _FIXED.pack(b"LRJ1", number, len(text), len(blob))
        crc = zlib.crc32(blob, zlib.crc32(text, zlib.crc32(fixed)))
        out.append(fixed + _CRC.pack(crc) + text + blob)
    return b"".join(out)


def rewritten(path: Path, change: dict[str, Any], where: str = "signals/force") -> bytes:
    """The journal with one record changed, a few behind the first of a dataset."""
    parts = records(path.read_bytes())
    spots = [i for i, (head, _) in enumerate(parts) if where in str(head.get("path"))]
    head, blob = parts[spots[len(spots) // 2]]
    rest = {key: value for key, value in change.items() if key != "blob"}
    parts[spots[len(spots) // 2]] = (head | rest, change.get("blob", blob))
    return written(parts)


def with_setup(path: Path, change: dict[str, Any]) -> bytes:
    """The journal with another setup."""
    parts = records(path.read_bytes())
    head, blob = parts[0]
    setup = json.loads(head["setup"]) | change
    parts[0] = ({"setup": json.dumps(setup)}, blob)
    return written(parts)
