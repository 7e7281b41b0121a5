"""All commands: what each does, its arguments and options, and an example that the build runs."""

from __future__ import annotations

from collections.abc import Iterator

import typer
from typer.core import TyperArgument, TyperGroup

from labrig.cli.app import all_commands
from labrig.cli.command import Command, CommandExample

HEAD = """\
# Commands

`labrig COMMAND --help` prints the same text. Each example is run when this documentation is built.
The page shows its output, without the lines that report progress; `...` at the end of a block means
that more lines follow. The folder of the examples is that of
[the first session](../../tutorials/first_session.md).

`labrig --install-completion` makes the shell complete commands and options with the Tab key. It
knows bash, zsh, fish and PowerShell; open a new terminal afterwards.
`labrig --show-completion` prints the script.

[How to add a command](../../howto/commands.md)

"""


def page() -> str:
    """Return the page's text; each example is a block that the build runs."""
    return HEAD + "\n".join(line for command in all_commands() for line in _section(command))


def paths(command: Command) -> list[str]:
    """Return what is typed for a command, or for each subcommand of a group."""
    click = _click(command)
    if not isinstance(click, TyperGroup):
        return [f"labrig {command.name}"]
    below = [f"labrig {command.name} {name}" for name in click.list_commands(_context(click))]
    return [f"labrig {command.name}", *below] if click.invoke_without_command else below


def examples(command: Command, path: str) -> list[CommandExample]:
    """Return the examples of what is typed; those of its subcommands are their own."""
    others = [other for other in paths(command) if other.startswith(f"{path} ")]
    return [
        example
        for example in command.examples
        if f"{example.line} ".startswith(f"{path} ")
        and not any(f"{example.line} ".startswith(f"{other} ") for other in others)
    ]


def _click(command: Command) -> typer.core.TyperCommand | TyperGroup:
    app = typer.Typer(rich_markup_mode=None)
    app.callback()(lambda: None)
    command.add_to(app)
    group = typer.main.get_command(app)
    return group.commands[command.name]


def _context(group: TyperGroup) -> typer.Context:
    return typer.Context(group)


def _section(command: Command) -> Iterator[str]:
    click = _click(command)
    yield f"## {command.name}\n"
    yield from _described(click)
    for path in paths(command):
        if path != f"labrig {command.name}":
            yield f"### {path.removeprefix('labrig ')}\n"
            yield from _described(click.get_command(_context(click), path.split()[-1]))
        for example in examples(command, path):
            yield from _block(example)


def _described(click: typer.core.TyperCommand | TyperGroup) -> Iterator[str]:
    text = (click.help or "").replace("<", "\\<")
    yield f"{text}\n"
    arguments = [p for p in click.params if isinstance(p, TyperArgument)]
    options = [p for p in click.params if p not in arguments and p.name != "help"]
    if arguments or options:
        yield "| argument or option | meaning | default |"
        yield "|---|---|---|"
        for parameter in [*arguments, *options]:
            yield _row(parameter)
        yield ""


def _row(parameter: typer.core.TyperArgument | typer.core.TyperOption) -> str:
    typed = [parameter.name] if isinstance(parameter, TyperArgument) else parameter.opts
    typed = [*typed, *(parameter.secondary_opts or [])]
    names = ", ".join(f"`{name}`" for name in typed)
    given = parameter.default
    plain = isinstance(given, str | int | float) and not isinstance(given, bool)
    default = "required" if parameter.required else f"`{given}`" if plain and given != "" else ""
    meaning = (parameter.help or "").replace("|", "\\|").replace("<", "\\<")
    return f"| {names} | {meaning} | {default} |"


def _block(example: CommandExample) -> Iterator[str]:
    if example.run_by:
        yield f"```console\n$ {example.line}\n```\n"
        yield f"It takes minutes; `{example.run_by}` runs it.\n"
        return
    yield "````{terminal}"
    yield ":prepared:"
    yield ":lines: 40"
    if example.exit_code:
        yield f":exit: {example.exit_code}"
    if example.answers:
        yield f":answers: {','.join(example.answers)}"
    if example.stop:
        yield ":stop:"
    for option, line in (("before", example.before), ("after", example.after)):
        if line:
            yield f":{option}: {line}"
    yield f"\n{example.line}\n````\n"
