"""Declare a run or reading of a closed session invalid, or take that back."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.screen import say
from labrig.files import as_text


def mark(
    session: Annotated[Path, typer.Argument(help="a session that is closed")],
    run: Annotated[int, typer.Option(min=1, help="number of the run, as labrig show lists it")],
    why: Annotated[str, typer.Option(help="the reason, in a line")],
    reading: Annotated[
        int | None,
        typer.Option(min=1, help="its number in the run; none: the whole run"),
    ] = None,
    who: Annotated[str, typer.Option(help="who marks; by default the user of this computer")] = "",
    undo: Annotated[bool, typer.Option("--undo", help="take a mark back")] = False,
) -> None:
    """Mark a run or reading of a session invalid, and say why.

    Marks are added to the file and change no recording. None is ever removed; --undo adds a line
    that withdraws one. An earlier analysis is then out of date.
    """
    from labrig.session import Mark, add_mark, open_session

    made = Mark(
        run=run - 1,
        reading=None if reading is None else reading - 1,
        why=" ".join(as_text(why).split()),
        who=" ".join(as_text(who).split()) or _user(),
        invalid=not undo,
    )
    add_mark(session, made)
    with open_session(session) as opened:
        what = opened.run(made.run).in_words(made.reading)
        say(
            f"{session}: " + (f"the mark of {what} is taken back" if undo else f"{what} is invalid")
        )
        if opened.outdated:
            say(opened.outdated)


def _user() -> str:
    import getpass

    try:
        return getpass.getuser()
    except (KeyError, OSError, ImportError):  # the system knows no name of this user
        return "not known"


COMMAND = Command(
    "mark",
    mark,
    order=85,
    examples=(
        CommandExample(
            line='labrig mark copy.h5 --run 2 --reading 3 --why "a bubble" --who "Ada Example"',
            before="cp session.h5 copy.h5",
        ),
    ),
)
