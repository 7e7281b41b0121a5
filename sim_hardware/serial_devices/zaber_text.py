"""The messages of Zaber's ASCII protocol, firmware 6.

A command is `/device axis id words...:checksum` and any newline; device, axis, id and check sum may
be left out. A reply is `@device axis id OK|RJ BUSY|IDLE warning data` CR LF, the id only where the
command had one.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

_CHECKED = re.compile(r"(.*):([0-9A-Fa-f]{2})")
_NUMBER = re.compile(r"-?[0-9]+|0x[0-9A-Fa-f]+")


@dataclass(frozen=True)
class ZaberCommand:
    """A command's fields."""

    device: int
    axis: int
    identifier: str | None
    words: tuple[str, ...]

    @classmethod
    def parse(cls, line: str) -> ZaberCommand | None:
        """Return the command in a line without its newline; None for what a device ignores."""
        if not line.startswith("/"):
            return None
        body = line[1:]
        checked = _CHECKED.fullmatch(body)
        if checked is not None:
            body = checked[1]
            if checksum(body) != int(checked[2], 16):
                return None
        words = body.split()
        numbers: list[str] = []
        while words and len(numbers) < 3 and _is_field(words[0], len(numbers)):
            numbers.append(words.pop(0))
        device, axis = ([number(text) or 0 for text in numbers] + [0, 0])[:2]
        return cls(device, axis, numbers[2] if len(numbers) == 3 else None, tuple(words))


def _is_field(word: str, fields: int) -> bool:
    """Return whether a word belongs to the head; `--` as the third field, the id: do not reply."""
    return _NUMBER.fullmatch(word) is not None or (word == "--" and fields == 2)


def number(text: str) -> int | None:
    """Return a whole number, decimal or hexadecimal with `0x`; None where it is none."""
    if _NUMBER.fullmatch(text) is None:
        return None
    return int(text, 16 if text.startswith("0x") else 10)


def checksum(body: str) -> int:
    """Return the check sum of a message without its first character."""
    return -sum(body.encode("ascii", "replace")) & 0xFF


def message(kind: str, body: str, *, checked: bool) -> bytes:
    """Return a message of the device: `@` reply, `!` alert, `#` info."""
    ending = f":{checksum(body):02X}" if checked else ""
    return f"{kind}{body}{ending}\r\n".encode("ascii", "replace")
