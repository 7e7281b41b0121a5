"""A session made of CSV tables."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.screen import say, warn


def import_tables(
    sheet: Annotated[Path, typer.Option(help="sheet.toml")],
    output: Annotated[Path, typer.Option("--output", "-o", help="the session file to make")],
    forces: Annotated[
        Path | None, typer.Option(help="forces.csv; without it --curves is needed")
    ] = None,
    curves: Annotated[Path | None, typer.Option(help="curves.csv")] = None,
    signals: Annotated[Path | None, typer.Option(help="signals.csv")] = None,
    about: Annotated[
        Path | None, typer.Option(help="about.toml; by default the one beside forces.csv, if any")
    ] = None,
) -> None:
    """Make a session of CSV tables, such as those of older measurements."""
    from labrig.session import import_session

    read = import_session(sheet, forces, output, curves=curves, signals=signals, about=about)
    for text in read.warnings:
        warn(f"warning: {text}")
    say(f"wrote {output}")


COMMAND = Command(
    "import",
    import_tables,
    order=220,
    examples=(
        CommandExample(
            line="labrig import --sheet sheet.toml --forces forces.csv --curves curves.csv "
            "-o old.h5"
        ),
    ),
)
