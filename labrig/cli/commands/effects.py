"""The catalogue of effects."""

from __future__ import annotations

from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.diagnosis import print_noted_table
from labrig.cli.options import Json
from labrig.cli.screen import print_json, say


def list_effects(context: typer.Context, as_json: Json = False) -> None:
    """List the effects that diagnose knows."""
    from labrig.report.tables.effects import catalogue_table, effect_as_dict
    from model.effects import catalogue

    if context.invoked_subcommand is not None:
        return
    every = catalogue()
    if as_json:
        print_json([effect_as_dict(one) for one in every.values()])
        return
    print_noted_table(catalogue_table(every))
    say("labrig effects show NAME says more about one.")


def show_effect(
    name: Annotated[str, typer.Argument(help="an effect's name")], as_json: Json = False
) -> None:
    """Show one effect.

    What it is, its form, how it shows, and what isolates it.
    """
    from labrig.report.tables.effects import effect_as_dict, effect_lines, parameter_table
    from model.effects import effect

    one = effect(name)
    if as_json:
        print_json(effect_as_dict(one))
        return
    for line in effect_lines(one):
        say(line)
    say()
    print_noted_table(parameter_table(one))


_app = typer.Typer(
    help="The catalogue of effects that diagnose knows.", invoke_without_command=True
)
_app.callback()(list_effects)
_app.command(name="show")(show_effect)
COMMAND = Command(
    "effects",
    _app,
    order=250,
    examples=(
        CommandExample(line="labrig effects"),
        CommandExample(line="labrig effects show gravity"),
    ),
)
