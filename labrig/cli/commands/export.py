"""CSV tables of a session."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.screen import say


def export(
    session: Annotated[Path, typer.Argument(help="an analysed session")],
    output: Annotated[Path, typer.Option("--output", "-o", help="the folder to write into")],
) -> None:
    """Write forces, curves, signals and control as CSV, about.toml, notes.csv and photographs."""
    from labrig.session import export_session

    for path in export_session(session, output):
        say(f"wrote {path}")


COMMAND = Command(
    "export",
    export,
    order=230,
    examples=(CommandExample(line="labrig export session.h5 -o tables"),),
)
