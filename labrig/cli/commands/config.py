"""The configuration files: their JSON Schemas."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.screen import say
from labrig.errors import BadInputError
from labrig.files import write_text


def schema(
    folder: Annotated[Path, typer.Argument(help="where to write the *.schema.json files")],
) -> None:
    """Write the JSON Schemas of the configuration files.

    Editors and forms use them.
    """
    from labrig.config.schema import schemas

    if folder.exists() and not folder.is_dir():
        raise BadInputError(f"{folder}: this is a file, a folder is needed.")
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in schemas().items():
        path = folder / f"{name}.schema.json"
        write_text(path, _as_text(content))
        say(f"wrote {path}")


def _as_text(content: dict[str, Any]) -> str:
    return json.dumps(content, indent=2, sort_keys=True) + "\n"


_app = typer.Typer(help="The configuration files.", no_args_is_help=True)
_app.command()(schema)
COMMAND = Command(
    "config",
    _app,
    order=240,
    examples=(CommandExample(line="labrig config schema schemas"),),
)
