"""Options without their value, and options given twice: what reads the command line lets pass.

It takes the next option for a value that lacks, and of two values the last.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any


def unclear_option(app: Any, arguments: Sequence[str]) -> str:
    """Return which option has no value, or has two and takes one, as a sentence; empty: none.

    `app`: the group of the commands, as typer has it. A value that looks like an option of the
    same command can still be given as --option=VALUE.
    """
    path, rest, command = ["labrig"], list(arguments), app
    while rest and (one := _of_group(command, rest[0])) is not None:
        command = one
        path.append(rest.pop(0))
    options = [each for each in command.params if each.param_type_name == "option"]
    said = _without_value(options, rest) or _given_twice(options, rest)
    return f"{said}; see {' '.join(path)} -h." if said else ""


def _of_group(command: Any, name: str) -> Any:
    return command.get_command(None, name) if hasattr(command, "get_command") else None


def _without_value(options: Sequence[Any], arguments: Sequence[str]) -> str:
    known = {name for each in options for name in (*each.opts, *each.secondary_opts)}
    takes_value = {name for each in options if not _is_switch(each) for name in each.opts}
    for option, value in pairwise(arguments):
        if option == "--":
            break
        if option in takes_value and value in known:
            return f"{option} needs a value, {value} is another option"
    return ""


def _given_twice(options: Sequence[Any], arguments: Sequence[str]) -> str:
    seen: set[str] = set()
    for option in _with_value(options, arguments):
        name = option.opts[0]
        if name in seen and not option.multiple:
            return f"{name} is given twice, and takes one value"
        seen.add(name)
    return ""


def _with_value(options: Sequence[Any], arguments: Sequence[str]) -> Iterator[Any]:
    """Yield the options that are given with a value, in their order."""
    by_name = {name: each for each in options if not _is_switch(each) for name in each.opts}
    rest = list(arguments)
    while rest and rest[0] != "--":
        argument = rest.pop(0)
        name, attached, _ = argument.partition("=")
        if name not in by_name and not argument.startswith("--"):
            name, attached = argument[:2], argument[2:]  # -oFILE
        if name in by_name:
            yield by_name[name]
            del rest[: 0 if attached else by_name[name].nargs]


def _is_switch(option: Any) -> bool:
    return bool(option.is_flag or getattr(option, "count", False))
