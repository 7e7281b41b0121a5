"""A recorded session, played again."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.options import Recorded


def replay(
    session: Recorded,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="record what is replayed, too")
    ] = None,
) -> None:
    """Play a session through the drivers that recorded it.

    Its configuration comes from the session itself. The measurements are those of the original. A
    session that was not completed is played as far as it was recorded; the replay ends as that
    session did, with its code: 4 where somebody stopped it, 5 where it failed or crashed.
    """
    from labrig.cli.follow import finish, replay_and_follow

    finish(replay_and_follow(session, output))


COMMAND = Command(
    "replay",
    replay,
    order=60,
    examples=(CommandExample(line="labrig replay session.h5"),),
)
