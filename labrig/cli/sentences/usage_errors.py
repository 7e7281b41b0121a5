"""What is wrong with the arguments of a command, as one sentence in plain words."""

from __future__ import annotations

import re
from itertools import pairwise

from typer.exceptions import TyperException

_PLAINER = (
    ("Value error, ", ""),
    (r"Input should be a valid integer, unable to parse string as an integer", "a whole number"),
    (r"Input should be a valid integer, got a number with a fractional part", "a whole number"),
    (r"Input should be a valid number, unable to parse string as a number", "a number"),
    (r"Input should be greater than or equal to (\S+)", r"a number from \1"),
    (r"Input should be less than or equal to (\S+)", r"a number up to \1"),
    (r"Input should be greater than (\S+)", r"a number above \1"),
    (r"Input should be less than (\S+)", r"a number below \1"),
    (r"Invalid value for '?(--?[\w-]+)'?(?: / '-\w')?: (a .*)", r"\1: \2 is needed"),
    (r"Invalid value for '?([^':]+)'?(?: / '-\w')?: ", r"\1: "),
    (r"Missing argument '(.+)'", r"\1 is missing"),
    (r"Missing option '(--?[\w-]+)'(?: / '-\w')?", r"\1 is missing"),
    (r"No such option: (\S+)", r"there is no option \1"),
    (r" ?\(Possible options: (.+)\)", r"; did you mean \1"),
    (r"No such command '(.+?)'", r"there is no command '\1'"),
    (r"\. Did you mean (.+)\?", r"; did you mean \1"),
    (r"(there is no command '(version|help)').*", r"\1; did you mean --\2"),
    (r"Option '(--?[\w-]+)' requires an argument", r"\1 needs a value"),
    (r"Option '(--?[\w-]+)' requires (\d+) arguments", r"\1 needs \2 values"),
    (r"Got unexpected extra arguments?(?:\(s\))? \((.+)\)", r"\1 is one argument too many"),
)


def usage_sentence(error: TyperException, arguments: list[str]) -> str:
    """Return what is wrong and where it is explained."""
    message: str = error.format_message()
    text = message.strip().rstrip(".")
    for found, plain in _PLAINER:
        text = re.sub(found, plain, text, flags=re.DOTALL)
    text = _with_value(text, arguments)
    context = getattr(error, "ctx", None)
    command = context.command_path if context is not None else _command(arguments)
    return f"{text}; see {command} -h."


def _with_value(text: str, arguments: list[str]) -> str:
    """Return the sentence about an option that wants a number, with what it was given."""
    asked = re.fullmatch(r"(--[\w-]+): (a (?:whole )?number) is needed", text)
    if asked is None:
        return text
    option, wanted = asked.groups()
    is_one = _is_whole if "whole" in wanted else _is_number
    wrong = next((value for value in _values_of(option, arguments) if not is_one(value)), "")
    point = ", with a point for its decimals" if "," in wrong else ""
    return f"{option} {wrong}: {wanted} is needed{point}" if wrong else text


def _values_of(option: str, arguments: list[str]) -> list[str]:
    after = [value for name, value in pairwise(arguments) if name == option]
    return after + [
        one.removeprefix(f"{option}=") for one in arguments if one.startswith(f"{option}=")
    ]


def _is_number(value: str) -> bool:
    try:
        float(value)
    except ValueError:
        return False
    return True


def _is_whole(value: str) -> bool:
    return value.strip().lstrip("+-").isdecimal()


def _command(arguments: list[str]) -> str:
    """Return the command that some arguments begin with, where the error does not know it."""
    known = bool(arguments) and not arguments[0].startswith("-")
    return f"labrig {arguments[0]}" if known else "labrig"
