"""CSV files in and out: import, export."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.screen import say, warn


def add_to(app: typer.Typer) -> None:
    """Add these commands."""
    app.command(name="import")(import_tables)
    app.command()(export)


def import_tables(
    sheet: Annotated[Path, typer.Option(help="sheet.toml")],
    forces: Annotated[Path, typer.Option(help="forces.csv")],
    output: Annotated[Path, typer.Option("--output", "-o", help="the session file to make")],
    curves: Annotated[Path | None, typer.Option(help="curves.csv")] = None,
    signals: Annotated[Path | None, typer.Option(help="signals.csv")] = None,
) -> None:
    """Make a session of CSV tables, such as those of older measurements."""
    from labrig.session import import_session

    for text in import_session(sheet, forces, output, curves=curves, signals=signals).warnings:
        warn(f"warning: {text}")
    say(f"wrote {output}")


def export(
    session: Annotated[Path, typer.Argument(help="an analysed session")],
    output: Annotated[Path, typer.Option("--output", "-o", help="the folder to write into")],
) -> None:
    """Write forces.csv, curves.csv and signals.csv of a session."""
    from labrig.session import export_session

    for path in export_session(session, output):
        say(f"wrote {path}")
