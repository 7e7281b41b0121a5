"""The report on a session."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.options import FigureFormats, Recorded
from labrig.cli.screen import progress, say, warn


def report(
    session: Recorded,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="the folder to write into; default NAME-report"),
    ] = None,
    figures: Annotated[
        Path | None, typer.Option(help="a folder for the figures; default OUTPUT/figures")
    ] = None,
    formats: FigureFormats = None,
) -> None:
    """Write a page with tables and figures about a session.

    The page is one file and needs no network.
    """
    from labrig.report.data.findings import workers
    from labrig.report.page.write import write_report
    from labrig.report.parts.style import known_formats

    wanted = known_formats(formats)
    with progress("report") as advance:
        page = write_report(
            session, output, figures=figures, formats=wanted, progress=advance, tell=warn,
            processes=workers(),
        )  # fmt: skip
    say(f"wrote {page}")


COMMAND = Command(
    "report",
    report,
    order=170,
    examples=(CommandExample(line="labrig report session.h5 -o report"),),
)
