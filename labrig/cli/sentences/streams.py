"""Standard streams: letters that they lack, and streams that are closed, broken or full."""

from __future__ import annotations

import codecs
import io
import os
import sys
from contextlib import suppress

_PLAIN = {
    "\N{RIGHTWARDS ARROW}": "->",
    "\N{MINUS SIGN}": "-",
    "\N{EN DASH}": "-",
    "\N{MICRO SIGN}": "u",
    "\N{MIDDLE DOT}": " ",
    "\N{PLUS-MINUS SIGN}": "+/-",
    "\N{SUPERSCRIPT TWO}": "^2",
    "\N{SUPERSCRIPT THREE}": "^3",
    "\N{INFINITY}": "inf",
    "\N{HORIZONTAL ELLIPSIS}": "...",
}
_BYTES = range(0xDC80, 0xDD00)  # what Python makes of a name's bytes that are no letters


def open_closed_streams() -> None:
    """Give standard streams that are closed to nowhere.

    Else the next file that is opened takes the place of one of them, and what a library writes to
    standard error ends up in the middle of a session.
    """
    inheritable = True  # else it is closed again in a process that is started
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            with suppress(OSError):
                os.set_inheritable(os.open(os.devnull, os.O_RDWR), inheritable)
    sys.stdin = sys.stdin or open(os.devnull, encoding="utf-8")  # noqa: SIM115 - for good
    sys.stdout = sys.stdout or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - as above
    sys.stderr = sys.stderr or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - as above


def show_what_can_be_shown() -> None:
    """Replace letters that the output lacks: Windows gives a pipe its old code page."""
    codecs.register_error("labrig-plain", _plain_letters)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="labrig-plain")


def _plain_letters(error: UnicodeError) -> tuple[str | bytes, int]:
    """Return for a letter that cannot be encoded a plain one: -> for an arrow, ? for others.

    A name's bytes that are no letters are printed as they are.
    """
    if not isinstance(error, UnicodeEncodeError):
        raise error
    letter, end = error.object[error.start], error.start + 1
    if ord(letter) in _BYTES and os.name != "nt":
        return bytes([ord(letter) - 0xDC00]), end
    return _PLAIN.get(letter, "?"), end


def output_takes_more() -> bool:
    """Whether what was printed so far can reach standard output."""
    try:
        sys.stdout.flush()
    except OSError:
        return False
    return True


def leave_streams() -> None:
    """Drop what a stream does not take: Python would try it again, and end with its own code."""
    for stream in (sys.__stdout__, sys.__stderr__):
        if stream is None:
            continue
        try:
            stream.flush()
        except OSError:
            with suppress(OSError, ValueError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        except ValueError:  # it was closed
            continue
