"""A pause of a running session: pause."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.screen import say
from labrig.errors import BadInputError
from labrig.files import typed


def pause(
    session: Annotated[Path, typer.Argument(help="the session file that is being written")],
    end: Annotated[bool, typer.Option("--end", help="let the session continue")] = False,
) -> None:
    """Pause a running session after this position, at 0 V.

    With --end it continues.

    Type it in another terminal than the one in which the session runs. The output is read back; the
    pause is recorded in the session's log. Ctrl-C and STOP end a paused session as any other.
    """
    from labrig.experiment.pause import PauseFile

    _require_running(session)
    file = PauseFile(session)
    if end:
        file.end()
        say(f"{session}: continues.")
    else:
        file.ask(_operator())
        again = f"labrig pause --end {typed(session)}"
        say(f"{session}: pauses after this position; {again} continues it.")


def _require_running(path: Path) -> None:
    from labrig.session import open_session
    from protocols.execution.events import Outcome

    with open_session(path, live=True) as session:
        if session.outcome is not Outcome.RUNNING:
            raise BadInputError(f"{path}: is not running ({session.outcome}); nothing can pause.")


def _operator() -> str:
    import getpass

    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):
        return "somebody"


COMMAND = Command(
    "pause",
    pause,
    order=56,
    examples=(
        CommandExample(
            line="labrig pause running.h5",
            before="labrig run rig/rig.toml rig/protocol.toml rig/sheet.toml -o running.h5 --yes "
            "> run.log 2>&1 & echo $! > run.pid; until [ -e running.h5 ]; do sleep 0.05; done",
            after="kill -KILL $(cat run.pid); sleep 1",
        ),
    ),
)
