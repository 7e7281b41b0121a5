"""The text of a table, in any of the ways in which laboratory programs write letters."""

from __future__ import annotations

import codecs

_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig", "UTF-8"),
    (codecs.BOM_UTF16_LE, "utf-16-le", "UTF-16"),
    (codecs.BOM_UTF16_BE, "utf-16-be", "UTF-16"),
)
LATIN = "Latin-1"
_DOS_END = b"\x1a"  # the last byte of a file of DOS


def decoded(raw: bytes) -> tuple[str, str]:
    """Return a file's text with plain line ends, and what its encoding is called.

    Raises UnicodeDecodeError for what is no text.
    """
    text, name = _decoded(raw)
    return text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n"), name


def _decoded(raw: bytes) -> tuple[str, str]:
    for mark, codec, name in _MARKS:
        if raw.startswith(mark):
            return raw.decode(codec), name
    if b"\0" in raw[:200]:  # UTF-16 without a mark: every other byte of plain letters is zero
        low = raw[1:200:2].count(0) > raw[0:200:2].count(0)
        return raw.decode("utf-16-le" if low else "utf-16-be"), "UTF-16"
    raw = raw.rstrip(_DOS_END)
    try:
        return raw.decode("utf-8"), "UTF-8"
    except UnicodeDecodeError:
        if any(byte < 32 and byte not in b"\t\n\r\f" for byte in raw[:10_000]):
            raise
        return _latin(raw), LATIN


def _latin(raw: bytes) -> str:
    """Return text as Windows wrote it in western Europe, or as ISO 8859-1 where that fails."""
    try:
        return raw.decode("cp1252")
    except UnicodeDecodeError:
        return raw.decode("latin-1")
