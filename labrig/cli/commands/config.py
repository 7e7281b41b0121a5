"""The keys of the configuration files, as JSON Schemas, and the columns of the tables."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.screen import print_table, say
from labrig.errors import BadInputError
from labrig.files import write_text


def schema(
    folder: Annotated[Path, typer.Argument(help="where to write the *.schema.json files")],
) -> None:
    """Write the JSON Schemas of the configuration files.

    They have all keys, bounds and descriptions. Editors and forms use them.
    """
    from labrig.config.schema import schemas

    if folder.exists() and not folder.is_dir():
        raise BadInputError(f"{folder}: this is a file, a folder is needed.")
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in schemas().items():
        path = folder / f"{name}.schema.json"
        write_text(path, _as_text(content))
        say(f"wrote {path}")


def columns() -> None:
    """Print the columns of the tables, with their axes and signs.

    `labrig import`, `fit` and `diagnose` read these tables, and `labrig export` writes them. The
    end of a column's name is its unit.
    """
    from labrig.session.tables.columns import AXES, CHANNEL, MEANINGS, TABLES

    say(f"Axes and signs: {AXES}\n")
    for name, (about, required, optional) in TABLES.items():
        rows = [[column, "yes", MEANINGS[column]] for column in required]
        rows += [[column, "no", MEANINGS[column]] for column in optional]
        if name == "forces.csv":
            rows.append([f"{CHANNEL}NAME_UNIT", "no", "a further input of the rig"])
        print_table(f"{name}: {about.rstrip('.')}", ["column", "required", "meaning"], rows)


def _as_text(content: dict[str, Any]) -> str:
    return json.dumps(content, indent=2, sort_keys=True) + "\n"


_app = typer.Typer(
    help="Keys of the configuration files, columns of the tables.", no_args_is_help=True
)
_app.command()(schema)
_app.command()(columns)
COMMAND = Command(
    "config",
    _app,
    order=240,
    examples=(
        CommandExample(line="labrig config schema schemas"),
        CommandExample(line="labrig config columns"),
    ),
)
