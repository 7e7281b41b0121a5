"""The application: our commands, and those of other distributions."""

from __future__ import annotations

import keyword
import platform
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from labrig.cli.command import Command
from labrig.cli.screen import say
from labrig.errors import StoppedError
from labrig.version import version

PACKAGE = "labrig.cli.commands"
HELP = {"--help", "-h"}


def app_for(arguments: Sequence[str]) -> TyperGroup:
    """Return the application with the commands that these arguments need.

    Where they begin with one of our commands, it alone is imported. Else all are, and those of
    other distributions are looked up.
    """
    if arguments[:1] == ["--version"]:
        return _app([])
    own = _own_command(arguments[0]) if arguments else None
    return _app(all_commands() if own is None else [own])


def prints_json(arguments: Sequence[str]) -> bool:
    """Return whether these arguments ask one of our own commands for JSON, and not for help."""
    if "--json" not in arguments or not HELP.isdisjoint(arguments):
        return False
    return _own_command(arguments[0]) is not None


def all_commands() -> list[Command]:
    """Return all commands in their order; warn of each that is left out."""
    from drivers.plugins import PluginWarning  # the drivers are slow to import
    from labrig.cli.command_folder import COMMANDS

    by_name: dict[str, Command] = {}
    for part in COMMANDS.parts().values():
        if part.part.name in by_name:
            text = (
                f"the command '{part.part.name}' of {part.distribution} is left out: "
                "there is a command of that name already."
            )
            warnings.warn(text, PluginWarning, stacklevel=2)
            continue
        by_name[part.part.name] = part.part
    return sorted(by_name.values(), key=lambda command: (command.order, command.name))


def module_of(name: str) -> str:
    """Return the name of the module that holds a command of ours."""
    module = name.replace("-", "_")
    return f"{module}_" if keyword.iskeyword(module) else module


def _own_command(name: str) -> Command | None:
    module = module_of(name)
    if not module.isidentifier() or find_spec(f"{PACKAGE}.{module}") is None:
        return None
    command: Command | None = getattr(import_module(f"{PACKAGE}.{module}"), "COMMAND", None)
    return command if command is not None and command.name == name else None


class _Application(TyperGroup):
    """The group of all commands. Of a Ctrl-C typer would make another exit code, and no sentence.

    typer keeps the types to itself.
    """

    def make_context(self, *args: Any, **kwargs: Any) -> Any:
        """Read the command line."""
        with _stopped_in_words():
            return super().make_context(*args, **kwargs)

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        with _stopped_in_words():
            return super().invoke(ctx)


@contextmanager
def _stopped_in_words() -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        raise StoppedError("stopped.") from None


def _app(commands: Iterable[Command]) -> TyperGroup:
    app = typer.Typer(
        name="labrig",
        cls=_Application,
        no_args_is_help=True,
        context_settings={"help_option_names": sorted(HELP)},
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
        help="Run, record and understand force and shape experiments on ionic-polymer actuator "
        "sheets.",
    )
    app.callback()(_options)
    names = []
    for command in commands:
        command.add_to(app)
        names.append(command.name)
    group = typer.main.get_command(app)
    assert isinstance(group, TyperGroup)  # noqa: S101 - it has a callback
    group.commands = {name: group.commands[name] for name in names}  # groups among the others
    return group


def _say_version(wanted: bool) -> None:
    if wanted:
        say(f"labrig {version()} (Python {platform.python_version()}, {platform.system()})")
        raise typer.Exit


def _options(
    show_version: Annotated[
        bool,
        typer.Option("--version", is_eager=True, callback=_say_version, help="print the version"),
    ] = False,
) -> None:
    """Make the application a group, also where it has one command alone."""
