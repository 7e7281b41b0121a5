"""The experiment."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.options import AboutFile
from labrig.errors import BadInputError
from labrig.files import check_free, check_session_name


def run(
    rig: Annotated[Path | None, typer.Argument(help="rig.toml")] = None,
    protocol: Annotated[Path | None, typer.Argument(help="protocol.toml")] = None,
    sheet: Annotated[Path | None, typer.Argument(help="sheet.toml")] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="the session file to make")
    ] = None,
    yes: Annotated[
        bool, typer.Option("--yes", help="answer the operator's questions with yes")
    ] = False,
    resume: Annotated[
        Path | None,
        typer.Option("--resume", help="a session to go on with; the files can be left out"),
    ] = None,
    about: AboutFile = None,
    controller: Annotated[
        Path | None,
        typer.Option(
            "--controller", help="controller.toml, which sets the voltage (labrig control)"
        ),
    ] = None,
    reference: Annotated[
        Path | None,
        typer.Option("--reference", help="force.csv (time_s, force_mN) that the force follows"),
    ] = None,
    diagnose: Annotated[
        bool,
        typer.Option(
            "--diagnose", help="diagnose after the run, and measure what separates the candidates"
        ),
    ] = False,
) -> None:
    """Run the experiment and record it.

    It asks for moves and moistening. Ctrl-C once stops after the current pulse, twice at once; the
    output is 0 V either way. With replay = "session.h5" in rig.toml, that session is played.

    With --resume, the missing runs of a session are made, and those of which no reading counts: its
    complete runs are copied into a new session (NAME-resumed.h5 unless -o names it), and the first
    incomplete one begins again. Without rig.toml, [hooks] and [publish] of the session's own are
    not used, and a world.toml or watch.token that it names is looked for beside the session.

    With --diagnose, the session is diagnosed after the run. Where several effects remain possible,
    the measurement that separates them is made as a session of its own (NAME-2.h5, ...), and all
    are diagnosed together; three times at most.

    With --controller and --reference, a controller sets the voltage at its place, so that the force
    follows the reference: force_mN above the force at 0 V from each time_s on, until the last
    row's time. Limits and guard are those of any run; a late or lost sample, a voltage at its limit
    for too long and any other fault end it at 0 V.
    """
    from labrig.cli.follow import finish, replay_and_follow, resume_and_follow, run_and_follow
    from labrig.config import ReplayConfig, load_rig
    from labrig.experiment.plan import ControlFiles

    _refuse_together(resume, controller, reference, diagnose=diagnose)
    if resume is not None and rig is None:
        finish(resume_and_follow(resume, None, output, yes=yes, about=about))
        return
    if rig is None or protocol is None or sheet is None:
        raise BadInputError(
            "labrig run needs rig.toml, protocol.toml and sheet.toml, in this order; with --resume "
            "none of them."
        )
    if resume is not None:
        files = rig, protocol, sheet
        finish(resume_and_follow(resume, files, output, yes=yes, about=about))
        return
    output = _free(output)
    config = load_rig(rig)
    if isinstance(config, ReplayConfig):
        if controller is not None:
            raise BadInputError("a recorded session in the rig's place obeys no controller.")
        finish(replay_and_follow(config.replay, output))
        return
    control = None
    if controller is not None and reference is not None:
        control = ControlFiles(controller, reference)
    finish(run_and_follow(rig, protocol, sheet, output, yes=yes, about=about, control=control))
    if diagnose:
        from labrig.cli.follow_up import follow_up

        follow_up(output, rig, sheet, yes=yes, about=about)


def _refuse_together(
    resume: Path | None, controller: Path | None, reference: Path | None, *, diagnose: bool
) -> None:
    """Raise BadInputError for options of which one makes no sense with, or without, the other."""
    if diagnose and resume is not None:
        raise BadInputError("--diagnose and --resume exclude each other; diagnose what is resumed.")
    if (controller is None) is not (reference is None):
        raise BadInputError("--controller and --reference go together; give both.")
    if controller is not None and (resume is not None or diagnose):
        raise BadInputError("--controller goes neither with --resume nor with --diagnose.")


def _free(output: Path | None) -> Path:
    """Return where the session is made; raise BadInputError before anything is opened for it."""
    if output is None:
        raise BadInputError("labrig run needs -o with the name of the session file to make.")
    check_session_name(output)
    if output.exists():
        raise BadInputError(f"{output} exists already; choose another name with -o.")
    check_free(output)
    return output


COMMAND = Command(
    "run",
    run,
    order=50,
    examples=(
        CommandExample(
            line="labrig run rig/rig.toml rig/protocol.toml rig/sheet.toml -o session.h5 --yes"
        ),
    ),
)
