"""A command of the command line: what it must provide.

A command is one file of `labrig/cli/commands`, or a module of another distribution with an entry
point of the group `labrig.commands`. The file defines COMMAND.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import typer

_NAME = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")


@dataclass(frozen=True, kw_only=True)
class CommandExample:
    """A command as somebody types it; the documentation runs it and shows what it prints.

    It is run in a folder that docs/howto/commands.md describes: a simulated rig, a session of it
    and its models. The build fails where it ends with another exit code than `exit_code`.
    """

    line: str  # as typed, such as "labrig plan rig/protocol.toml"
    answers: tuple[str, ...] = ()  # typed at its questions, one after the other
    exit_code: int = 0
    before: str = ""  # a shell's line that is run first and not shown
    after: str = ""  # the same, afterwards
    stop: bool = False  # it serves until Ctrl-C, which is pressed when it has printed a line
    run_by: str = ""  # what runs it instead, where it takes minutes


@dataclass(frozen=True)
class Command:
    """One command, or a group of commands under one name.

    `action` is a function whose parameters are typer's arguments and options and whose docstring
    is the help, or a `typer.Typer` with `help=` whose commands are the subcommands. The function
    is called once, in the main thread, and may block; it prints with `labrig.cli.screen` and ends
    a failure with a `LabrigError` of one sentence, or `typer.Exit` with a documented exit code.
    Whatever else it raises is reported as a fault of the program.

    The module is imported whenever labrig starts: import what is slow inside the function.
    """

    name: str  # as typed: lower case, words joined with "-"
    action: Callable[..., None] | typer.Typer
    order: int = 1000  # commands are listed in `labrig --help` in this order, then by name
    # One for the command, or for each subcommand; shown by its help and run for the documentation.
    examples: tuple[CommandExample, ...] = ()

    @property
    def help(self) -> str:
        """Return the help; its first sentence is shown in `labrig --help`."""
        if isinstance(self.action, typer.Typer):
            text = self.action.info.help
            return text if isinstance(text, str) else ""
        return inspect.getdoc(self.action) or ""

    def add_to(self, app: typer.Typer) -> None:
        """Add this command to the application."""
        if isinstance(self.action, typer.Typer):
            for sub in self.action.registered_commands:
                name = str(sub.name or getattr(sub.callback, "__name__", ""))
                sub.epilog = example_help(self.examples, f"labrig {self.name} {name}")
            group = example_help(self.examples, f"labrig {self.name}")
            app.add_typer(self.action, name=self.name, epilog=group)
        else:
            epilog = example_help(self.examples, f"labrig {self.name}")
            app.command(name=self.name, epilog=epilog)(self.action)


def example_help(examples: Iterable[CommandExample], path: str) -> str | None:
    """Return the examples of what is typed, with those of its subcommands, as help shows them."""
    lines = [e.line for e in examples if f"{e.line} ".startswith(f"{path} ")]
    head = "Example:" if len(lines) == 1 else "Examples:"
    return "\b\n" + "\n".join([head, *(f"  {line}" for line in lines)]) if lines else None


def faults(command: object) -> list[str]:
    """Return what is wrong with a command, a sentence without its full stop each."""
    if not isinstance(command, Command):
        return [f"COMMAND is a {type(command).__name__}, not a labrig.Command"]
    found = []
    name, order, action = _unchecked(command)
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        found.append(f"its name {name!r} is not lower-case words joined with '-'")
    if not isinstance(order, int):
        found.append(f"its order {order!r} is not a whole number")
    if not isinstance(action, typer.Typer) and not callable(action):
        return [*found, "its action is neither a function nor a typer.Typer"]
    found += _faulty_examples(command)
    if not command.help.strip():
        found.append("it has no help: give its function a docstring, or its typer.Typer help=")
    return found or _not_built(command)


def _faulty_examples(command: Command) -> list[str]:
    """Return what is wrong with a command's examples."""
    examples = command.examples
    if not isinstance(examples, tuple) or not all(isinstance(e, CommandExample) for e in examples):
        return ["its examples are not a tuple of labrig.CommandExample"]
    words = ["labrig", command.name]
    astray = [e.line for e in examples if e.line.split()[:2] != words]
    return [f"its example {line!r} does not begin with '{' '.join(words)}'" for line in astray]


def _unchecked(command: Command) -> tuple[object, object, object]:
    """Return the fields as they are: other people's code may break the types."""
    return command.name, command.order, command.action


def _not_built(command: Command) -> list[str]:
    """Return why typer cannot make a command of it, if it cannot."""
    app = typer.Typer()
    app.callback()(lambda: None)
    try:
        command.add_to(app)
        typer.main.get_command(app)
    except Exception as error:  # noqa: BLE001 - typer raises what it meets in the annotations
        return [f"typer cannot read its arguments and options ({type(error).__name__}: {error})"]
    return []
