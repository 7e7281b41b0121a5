"""A session for other programs: CSV tables, Parquet, xarray, Bluesky documents, RO-Crate, video."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.screen import say


def export(
    session: Annotated[Path, typer.Argument(help="a session; csv and parquet want it analysed")],
    output: Annotated[Path, typer.Option("--output", "-o", help="the folder to write into")],
    name: Annotated[
        str,
        typer.Option(
            "--as",
            metavar="FORMAT",
            help="csv, parquet, xarray (netCDF), bluesky (documents), crate (RO-Crate), "
            "video (a file for each run), or another distribution's",
        ),
    ] = "csv",
) -> None:
    """Write a session for other programs.

    As CSV tables with notes and photographs, or --as another format.
    """
    from labrig.exports.choice import export as write

    for path in write(session, output, name):
        say(f"wrote {path}")


COMMAND = Command(
    "export",
    export,
    order=230,
    examples=(CommandExample(line="labrig export session.h5 -o tables"),),
)
