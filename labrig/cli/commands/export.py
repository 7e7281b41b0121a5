"""CSV tables of a session."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command
from labrig.cli.screen import say


def export(
    session: Annotated[Path, typer.Argument(help="an analysed session")],
    output: Annotated[Path, typer.Option("--output", "-o", help="the folder to write into")],
) -> None:
    """Write a session as CSV tables, notes and photographs.

    forces.csv, curves.csv, signals.csv, control.csv, about.toml, notes.csv and photographs.
    """
    from labrig.session import export_session

    for path in export_session(session, output):
        say(f"wrote {path}")


COMMAND = Command("export", export, order=230)
