"""What a person may have meant where a TOML file is wrong: signs of another program."""

from __future__ import annotations

import re
import unicodedata

_PLACE = re.compile(r"\(at line (\d+), column (\d+)\)")
_ESCAPE = ("Unescaped", "Invalid hex value")
_COMMA = re.compile(r"\d,\d")


def toml_hint(text: str, said: str) -> str:
    """Return what stands at the place that the parser has named; often nothing."""
    place = _PLACE.search(said)
    if place is None:
        return ""
    line, at = text.split("\n")[int(place[1]) - 1], int(place[2]) - 1
    if said.startswith(_ESCAPE):
        return "; a path is written with /, or in 'single quotes'"
    if _COMMA.fullmatch(line[max(at - 1, 0) : at + 2]):
        return "; a number needs a point, not a comma, for its decimals"
    sign = line[at : at + 1]
    if not sign or (sign.isascii() and sign.isprintable()):
        return ""
    return f", where {_named(sign)} stands"


def _named(sign: str) -> str:
    if sign.isprintable():
        return f"'{sign}'"
    return unicodedata.name(sign, f"U+{ord(sign):04X}")
