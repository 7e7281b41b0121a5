"""A note or a photograph for a session."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.screen import say
from labrig.errors import BadInputError
from labrig.files import as_text


def note(
    session: Annotated[Path, typer.Argument(help="a session, also a running one")],
    text: Annotated[str, typer.Argument(help="what is to be noted")] = "",
    photograph: Annotated[
        Path | None, typer.Option("--photograph", help="a JPEG or PNG; the text is its caption")
    ] = None,
    who: Annotated[
        str, typer.Option("--who", help="by default the operator that the session states")
    ] = "",
) -> None:
    """Add a note or a photograph to a session, running or not.

    The recording is not changed, and no note is ever removed. During a run the note is kept beside
    the file until that is closed, or recovered.
    """
    from labrig.session import Note, add_note
    from labrig.session.notes.add import stated_operators
    from labrig.session.notes.photograph import photograph_note, read_photograph_file

    if not text.strip() and photograph is None:
        raise BadInputError("labrig note needs a text, or --photograph with a file.")
    text, who = as_text(text), as_text(who) or stated_operators(session)
    if photograph is None:
        made = Note(who=who, text=text)
    else:
        content = read_photograph_file(photograph)
        made = photograph_note(content, who=who, text=text, file_name=as_text(str(photograph)))
    if add_note(session, made):
        say(f"added to {session}")
    else:
        say(f"kept beside {session}; it is added when the session is closed or recovered")


COMMAND = Command(
    "note",
    note,
    order=75,
    examples=(
        CommandExample(line='labrig note session.h5 "a bubble at the clamp" --who "Ada Example"'),
    ),
)
