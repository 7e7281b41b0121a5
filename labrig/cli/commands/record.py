"""At the rig, and with its files: run, replay, safe, show, recover, verify."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.screen import print_json, print_table, say, warn
from labrig.errors import BadInputError, LabrigError, OutputUnknownError

Rig = Annotated[Path, typer.Argument(help="rig.toml")]
Json = Annotated[bool, typer.Option("--json", help="print one JSON object")]


def add_to(app: typer.Typer) -> None:
    """Add these commands."""
    for command in (run, replay, safe, show, recover, verify):
        app.command()(command)


def run(
    rig: Annotated[Path | None, typer.Argument(help="rig.toml")] = None,
    protocol: Annotated[Path | None, typer.Argument(help="protocol.toml")] = None,
    sheet: Annotated[Path | None, typer.Argument(help="sheet.toml")] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="the session file to make")
    ] = None,
    yes: Annotated[
        bool, typer.Option("--yes", help="take whatever is asked of the operator as done")
    ] = False,
    resume: Annotated[
        Path | None,
        typer.Option("--resume", help="a session to go on with; the files can be left out"),
    ] = None,
    diagnose: Annotated[
        bool,
        typer.Option(
            "--diagnose", help="then say what the model is missing, and measure what separates it"
        ),
    ] = False,
) -> None:
    """Run the experiment and record it.

    Asks for moves and moistening. Ctrl-C once stops after the current pulse, twice at once; the
    output is 0 V either way. With a rig whose rig.toml says replay = "session.h5", plays that.

    With --resume, runs what a session lacks: its complete runs are copied into a new session
    (NAME-resumed.h5 unless -o says otherwise), the first incomplete one is begun anew.

    With --diagnose, goes on after the run: where the data leave several effects open, proposes the
    measurement that separates them, runs it as a session of its own (NAME-2.h5, ...) and diagnoses
    all together, three times at most.
    """
    from labrig.cli.follow import resume_and_follow, run_and_follow
    from labrig.config import ReplayConfig, load_rig

    if diagnose and resume is not None:
        raise BadInputError("--diagnose and --resume exclude each other; diagnose what is resumed.")
    if resume is not None and rig is None:
        _finish(resume_and_follow(resume, None, output, yes=yes))
        return
    if rig is None or protocol is None or sheet is None:
        raise BadInputError(
            "labrig run needs rig.toml, protocol.toml and sheet.toml, in this order; with --resume "
            "none of them."
        )
    if resume is not None:
        _finish(resume_and_follow(resume, (rig, protocol, sheet), output, yes=yes))
        return
    if output is None:
        raise BadInputError("labrig run needs -o with the name of the session file to make.")
    config = load_rig(rig)
    if isinstance(config, ReplayConfig):
        replay(config.replay, output)
        return
    _finish(run_and_follow(rig, protocol, sheet, output, yes=yes))
    if diagnose:
        from labrig.cli.follow_up import follow_up

        follow_up(output, rig, sheet, yes=yes)


def replay(
    session: Annotated[Path, typer.Argument(help="a recorded session")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="record what is replayed, too")
    ] = None,
) -> None:
    """Play a recorded session through the same drivers and scheduler that recorded it.

    Its configuration comes from the session itself. The measurements are those of the original.
    """
    from labrig.cli.follow import replay_and_follow

    _finish(replay_and_follow(session, output))


def _finish(result: object) -> None:
    """Say how it ended, and end with its code."""
    from labrig.experiment.run import Result

    assert isinstance(result, Result)  # noqa: S101 - for the type checker
    said = f"{result.path}: {result.outcome.value}: {result.status.text.rstrip('.')}."
    if result.code:
        warn(f"labrig: {said}")
        raise typer.Exit(int(result.code))
    say(said)


def safe(rig: Rig) -> None:
    """Write 0 V to the output and read it back, whatever has happened before.

    Takes the boards from whoever still holds them. Ends with code 6 when the output is not known
    to be at 0 V: then switch the amplifier off by hand.
    """
    from labrig.experiment.safety import make_rig_safe

    report = make_rig_safe(rig)
    if not report.is_safe:
        raise OutputUnknownError(report.text)
    say(report.text)


def show(
    session: Annotated[Path, typer.Argument(help="a recorded session, also a running one")],
    compare: Annotated[
        Path | None, typer.Option(help="another session: what differs, dataset by dataset")
    ] = None,
    log: Annotated[bool, typer.Option("--log", help="the event log, line by line")] = False,
    as_json: Json = False,
) -> None:
    """Show what a session holds: outcome, runs, readings, losses, lateness."""
    from labrig.report.tables.overview import overview
    from labrig.session import compare_sessions, open_session

    if compare is not None:
        differences = compare_sessions(session, compare)
        if as_json:
            print_json({"equal": not differences, "differences": differences})
        else:
            say("\n".join(differences) or "the sessions are equal")
        return
    with open_session(session, live=True) as opened:
        found = overview(opened)
    if as_json:
        print_json(found.as_dict())
        return
    for table in found.tables(log=log):
        print_table(table.title, table.columns, table.rows)


def recover(
    session: Annotated[Path, typer.Argument(help="a session whose program died")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="the whole file to make")
    ] = None,
    in_place: Annotated[
        bool, typer.Option("--in-place", help="put it in the place of the original")
    ] = False,
) -> None:
    """Make an ordinary file of a session whose program was killed or whose power failed.

    The original is never altered without --in-place; the new file is NAME-recovered.h5 by default.
    """
    from labrig.session import recover as recover_session

    if in_place and output is not None:
        raise BadInputError("--in-place and --output exclude each other; give one of them.")
    report = recover_session(session, output, in_place=in_place)
    for note in report.notes:
        say(note)
    if report.output is None:
        say(f"{session}: is whole; there is nothing to recover.")
        return
    say(
        f"wrote {report.output}: {report.outcome.value}, {report.runs_completed} runs complete, "
        f"{report.readings} readings, {report.frames} frames."
    )


def verify(
    session: Annotated[Path, typer.Argument(help="a recorded session")], as_json: Json = False
) -> None:
    """Check a session's structure, checksums and completeness. Ends with code 2 on a fault."""
    from labrig.session import verify as verify_session

    checks = verify_session(session)
    good = all(check.ok for check in checks)
    if as_json:
        print_json({"ok": good, "checks": [check.as_dict() for check in checks]})
    else:
        rows = [[c.word, c.name, c.found, c.wanted] for c in checks]
        print_table(f"{session}", ["", "check", "found", "wanted"], rows)
    if not good:
        faults: LabrigError = BadInputError(
            f"{session}: {', '.join(c.name for c in checks if not c.ok)}: not as it should be."
        )
        raise faults
