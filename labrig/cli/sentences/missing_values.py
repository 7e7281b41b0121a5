"""Options without their value: what reads the command line takes the next option for it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any


def missing_value(app: Any, arguments: Sequence[str]) -> str:
    """Return which option has no value, as a sentence; empty: all have one.

    `app`: the group of the commands, as typer has it. A value that looks like an option of the
    same command can still be given as --option=VALUE.
    """
    path, rest, command = ["labrig"], list(arguments), app
    while rest and rest[0] in getattr(command, "commands", {}):
        command = command.commands[rest[0]]
        path.append(rest.pop(0))
    options = [each for each in command.params if each.param_type_name == "option"]
    known = {name for each in options for name in (*each.opts, *each.secondary_opts)}
    takes_value = {name for each in options if not _is_switch(each) for name in each.opts}
    for option, value in pairwise(rest):
        if option == "--":
            break
        if option in takes_value and value in known:
            return f"{option} needs a value, {value} is another option; see {' '.join(path)} -h."
    return ""


def _is_switch(option: Any) -> bool:
    return bool(option.is_flag or getattr(option, "count", False))
