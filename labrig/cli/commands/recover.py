"""An ordinary file of a session whose program died."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.screen import say
from labrig.errors import BadInputError


def recover(
    session: Annotated[Path, typer.Argument(help="a session whose program died")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="the whole file to make")
    ] = None,
    in_place: Annotated[
        bool, typer.Option("--in-place", help="put it in the place of the original")
    ] = False,
) -> None:
    """Make an ordinary file of a session that crashed.

    The program was killed, or the power failed.

    The original is never altered without --in-place; the new file is NAME-recovered.h5 by default.
    """
    from labrig.session import recover as recover_session

    if in_place and output is not None:
        raise BadInputError("--in-place and --output exclude each other; give one of them.")
    report = recover_session(session, output, in_place=in_place)
    for note in report.notes:
        say(note)
    say(report.text)


COMMAND = Command(
    "recover",
    recover,
    order=90,
    # The session that the example of `labrig pause` has left.
    examples=(CommandExample(line="labrig recover running.h5"),),
)
