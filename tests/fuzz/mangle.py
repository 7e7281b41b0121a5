"""Damage, from fixed seeds: to bytes, and to texts that keep something of their form."""

from __future__ import annotations

import random
import re

_NUMBER = re.compile(r"-?\d+(\.\d+)?([eE][+-]?\d+)?")
NUMBERS = (
    "0",
    "-1",
    "1e400",
    "-1e308",
    "5e-324",
    "nan",
    "inf",
    "-inf",
    "9" * 30,
    "9" * 5000,
    "1" + "0" * 18,
    "2147483648",
    "4294967295",
    "true",
    '"word"',
    "[]",
    "{}",
    "''",
    "1979-05-27",
    "1,5",
    "0x10",
    "٣",
)
LINES = (
    "[",
    "[[",
    "[[places]]",
    "= 1",
    '"',
    "'''",
    "\0",
    "a.b.c.d = 1",
    "[rig.ni]",
    "é = 'ü'",
    '"\\ud800" = 1',
    "\ufeff",
    "}",
    ",,,,,,,,,",
    "x" * 200_000,
)
DEEP = 100_000  # more brackets than any parser should follow down


def bytes_of(raw: bytes, dice: random.Random) -> bytes:
    """Bytes with one to three injuries: bits flipped, a piece gone, doubled, zeroed, or cut off."""
    out = bytearray(raw)
    for _ in range(dice.randint(1, 3)):
        if not out:
            break
        at = dice.randrange(len(out))
        end = min(len(out), at + dice.choice((1, 2, 4, 8, 64, 512)))
        match dice.randrange(6):
            case 0 | 1:
                out[at] ^= 1 << dice.randrange(8)
            case 2:
                del out[at:end]
            case 3:
                out[at:at] = out[at:end]
            case 4:
                out[at:end] = dice.choice((b"\0", b"\xff")) * (end - at)
            case _:
                del out[at:]
    return bytes(out)


def text_of(text: str, dice: random.Random) -> str:
    """A text with one to three injuries to its numbers, words and lines."""
    for _ in range(dice.randint(1, 3)):
        lines = text.split("\n")
        at = dice.randrange(len(lines))
        match dice.randrange(7):
            case 0 | 1 | 2:
                text = _other_number(text, dice)
            case 3:
                del lines[at]
                text = "\n".join(lines)
            case 4:
                lines.insert(at, dice.choice((*LINES, *lines)))
                text = "\n".join(lines)
            case 5:
                begin = dice.randrange(len(text) + 1)
                text = text[:begin] + dice.choice(LINES) + text[begin:]
            case _:
                text = text[: dice.randrange(len(text) + 1)]
    return text


def _other_number(text: str, dice: random.Random) -> str:
    found = list(_NUMBER.finditer(text))
    if not found:
        return text
    match = dice.choice(found)
    return text[: match.start()] + dice.choice(NUMBERS) + text[match.end() :]
