"""The report on a session."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command
from labrig.cli.options import Recorded
from labrig.cli.screen import progress, say, warn


def report(
    session: Recorded,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="the folder to write into; default NAME-report"),
    ] = None,
) -> None:
    """Write tables, figures and one self-contained page about a session."""
    from labrig.report.page.write import write_report

    with progress("report") as advance:
        page = write_report(session, output, progress=advance, tell=warn)
    say(f"wrote {page}")


COMMAND = Command("report", report, order=170)
