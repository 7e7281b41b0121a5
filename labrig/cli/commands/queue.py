"""Several experiments, one after the other."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.screen import say, warn
from labrig.errors import BadInputError, LabrigError
from labrig.files import check_free, make_folder

if TYPE_CHECKING:
    from labrig.experiment.queue import QueuedRun


def queue(
    protocols: Annotated[list[Path], typer.Argument(help="protocol.toml, in their order")],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="folder for the sessions; made when missing")
    ],
    rig: Annotated[Path, typer.Option(help="rig.toml")] = Path("rig.toml"),
    sheet: Annotated[
        Path | None, typer.Option(help="sheet.toml; by default the one beside rig.toml")
    ] = None,
    yes: Annotated[
        bool, typer.Option("--yes", help="answer the operator's questions with yes")
    ] = False,
) -> None:
    """Run several protocols, one session each.

    The sessions are NN-PROTOCOL.h5 in the folder.

    All are checked (files, limits, disk space) before the first begins. The queue stops at a
    session that is not completed, and ends with its exit code. [hooks] of rig.toml are called when
    a session waits, has stopped or is done.
    """
    from labrig.experiment.queue import QueuedRun, faults_of

    sheet = sheet or rig.parent / "sheet.toml"
    runs = [
        QueuedRun(
            rig=rig,
            protocol=protocol,
            sheet=sheet,
            session=output / f"{number:02d}-{protocol.stem}.h5",
        )
        for number, protocol in enumerate(protocols, start=1)
    ]
    faults = faults_of(runs)
    if faults:
        raise BadInputError("\n".join(["nothing was begun:", *faults]))
    make_folder(output)
    check_free(runs[0].session)
    for number, run in enumerate(runs):
        say(f"session {number + 1} of {len(runs)}: {run.protocol} -> {run.session}")
        _run(run, runs[number + 1 :], yes=yes)


def _run(run: QueuedRun, left: list[QueuedRun], *, yes: bool) -> None:
    """Run one; whatever ends it but its completion ends the queue."""
    from labrig.cli.follow import finish, run_and_follow

    try:
        finish(run_and_follow(run.rig, run.protocol, run.sheet, run.session, yes=yes))
    except (LabrigError, typer.Exit, KeyboardInterrupt):
        if left:
            warn(f"the queue stops; not begun: {', '.join(one.session.name for one in left)}")
        raise


COMMAND = Command(
    "queue",
    queue,
    order=55,
    examples=(
        CommandExample(line="labrig queue rig/protocol.toml --rig rig/rig.toml -o night --yes"),
    ),
)
