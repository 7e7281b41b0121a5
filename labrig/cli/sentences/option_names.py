"""The options of the command line that stand for arguments of Python functions."""

from __future__ import annotations

from labrig.errors import ArgumentWarning, BadArgumentError

_OTHERWISE = {
    "format": "--as",
    "section_mm": "--section",
    "start_ms": "--start",
    "values": "--value",
}


def option_of(argument: str) -> str:
    """Return the option that stands for an argument: --bootstrap for bootstrap."""
    return _OTHERWISE.get(argument, f"--{argument.replace('_', '-')}")


def with_options(told: Warning | Exception | str) -> str:
    """Return the text of an error or a warning, its arguments named as options."""
    if isinstance(told, BadArgumentError | ArgumentWarning):
        return told.in_words(option_of)
    return str(told)
