"""CSV tables and videos of a session."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command
from labrig.cli.screen import progress, say


def export(
    session: Annotated[Path, typer.Argument(help="an analysed session")],
    output: Annotated[Path, typer.Option("--output", "-o", help="the folder to write into")],
    video: Annotated[
        bool, typer.Option("--video", help="also the frames of each run, as run-NN-SHEET-PLACE.avi")
    ] = False,
) -> None:
    """Write forces, curves, signals and control as CSV, about.toml, notes.csv and photographs.

    With --video, also a video of each run at the rate of its frames; time, voltage and force are
    written below the picture.
    """
    from labrig.session import export_session, open_session

    written = export_session(session, output)
    if video:
        from labrig.analysis.video import write_videos

        with open_session(session) as recorded, progress("video") as advance:
            written = [*written, *write_videos(recorded, output, advance)]
    for path in written:
        say(f"wrote {path}")


COMMAND = Command("export", export, order=230)
