"""What a model predicts, at rest and in time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.model_errors import errors_of, say_errors, warn_of_misses
from labrig.cli.options import EachConfiguration, Json, ModelFile
from labrig.cli.screen import print_json, print_table, say, warn
from labrig.errors import BadInputError

if TYPE_CHECKING:
    from labrig.motion.simulated import OutputTimes
    from model import Prediction

_EVERY_MS, _START_MS = 1.0, 0.0
Given = TypeVar("Given", str, float)


def simulate(
    model: ModelFile,
    configuration: EachConfiguration = None,
    position_mm: Annotated[
        list[float] | None,
        typer.Option(help="along the arc; repeatable. With --time one, or none: the sheet is free"),
    ] = None,
    voltage: Annotated[list[float] | None, typer.Option(help="in V; repeatable")] = None,
    session: Annotated[
        int,
        typer.Option(
            min=0, help="as in this one of the sessions diagnosed together; 0: as in their mean"
        ),
    ] = 0,
    as_json: Json = False,
    in_time: Annotated[
        bool, typer.Option("--time", help="the motion under --drive instead; needs [...dynamic]")
    ] = False,
    drive: Annotated[
        Path | None,
        typer.Option(
            help="with --time: protocol.toml, or a CSV table time_s,voltage_V, each voltage held "
            "until the next row, the last row being the end"
        ),
    ] = None,
    run: Annotated[
        int | None,
        typer.Option(
            help="with --time: that run of labrig plan (an extra such as a release), at its own "
            "place; by default the protocol's pulses"
        ),
    ] = None,
    every_ms: Annotated[float, typer.Option(help="with --time: between two rows")] = _EVERY_MS,
    start_ms: Annotated[
        float,
        typer.Option(
            "--start", metavar="MS", help="with --time: the first row; the motion begins at 0"
        ),
    ] = _START_MS,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="with --time: motion.h5 or motion.csv")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="overwrite that file")] = False,
) -> None:
    """Predict force and shape with a model.

    All combinations of what is given are predicted.

    With --time: force, current and shape at every millisecond of a drive, from rest at 0 V.
    """
    given = {
        "--drive": drive is not None,
        "--run": run is not None,
        "--every-ms": every_ms != _EVERY_MS,
        "--start": start_ms != _START_MS,
        "-o": output is not None,
        "--force": force,
    }
    if not in_time:
        _refuse(given, "is of a motion; give --time with it")
        _at_rest(model, configuration, position_mm, voltage, session, as_json=as_json)
        return
    from labrig.motion.simulated import OutputTimes

    given = {"--voltage": bool(voltage), "--session": session > 0, "--json": as_json}
    _refuse(given, "is of the sheet at rest; leave it out, or --time")
    if drive is None or output is None:
        raise BadInputError("--time needs --drive (protocol.toml or a table) and -o (a file).")
    named = {"--configuration": configuration, "--position-mm": position_mm}
    for option, values in named.items():
        if len(values or []) > 1:
            raise BadInputError(f"{option}: give one with --time; a motion is of one place.")
    if run is not None:
        given = {option: bool(values) for option, values in named.items()}
        _refuse(given, f"is what run {run} of the protocol says; leave it or --run out")
    if output.exists() and not force:
        raise BadInputError(f"{output}: is already there; give --force to overwrite it.")
    place = _only(configuration), _only(position_mm)
    _in_time(model, place, (drive, run), OutputTimes(1e-3 * every_ms, 1e-3 * start_ms), output)


def _only(values: list[Given] | None) -> Given | None:
    return values[0] if values else None


def _refuse(given: dict[str, bool], why: str) -> None:
    """Raise BadInputError for the first option that is given where it makes no sense."""
    for option, is_given in given.items():
        if is_given:
            raise BadInputError(f"{option} {why}.")


def _at_rest(
    model: Path,
    configuration: list[str] | None,
    position_mm: list[float] | None,
    voltage: list[float] | None,
    session: int,
    *,
    as_json: bool,
) -> None:
    from labrig.model_file import load_model
    from model import predict

    if not position_mm or not voltage:
        raise BadInputError("give at least one --position-mm and one --voltage.")
    known = load_model(model)
    if session > known.sessions:
        many = f"more than {known.sessions} sessions" if known.sessions else "sessions"
        raise BadInputError(
            f"--session {session}: {model.name} has nothing that differs between {many}."
        )
    known = known.in_session(session)
    found = [
        predict(known, name, 1e-3 * position, volts)
        for name in configuration or known.sheets
        for position in position_mm
        for volts in voltage
    ]
    errors = errors_of(known, dict.fromkeys(one.configuration for one in found))
    warn_of_misses(errors)
    if as_json:
        print_json([one.to_json() for one in found])
        return
    columns = ["sheet", "p mm", "V", "F mN", "N mN", "contact at mm", "angle deg", "remark"]
    print_table(f"{model}", columns, [_prediction_row(one) for one in found])
    say_errors(errors)


def _in_time(
    model: Path,
    place: tuple[str | None, float | None],
    driven: tuple[Path, int | None],
    times: OutputTimes,
    output: Path,
) -> None:
    from labrig.motion.drive import load_drive
    from labrig.motion.motion_file import require_ending, write_motion
    from labrig.motion.simulated import SUMMARY_COLUMNS, simulated_run, summary_rows

    require_ending(output)
    configuration, position_mm = place
    drive, number = driven
    found = simulated_run(
        model,
        load_drive(drive, number),
        times,
        configuration,
        None if position_mm is None else 1e-3 * position_mm,
    )
    if found.has_effects:
        warn(f"{model}: its effects act on the sheet at rest only, and are not in the motion.")
    made_from = {"model_file": model.name, "drive_file": drive.name}
    write_motion(found, made_from, output)
    print_table(f"{model}: {found.place}", SUMMARY_COLUMNS, summary_rows(found))
    say(f"wrote {output}: {len(found.motion.time_s)} times, {len(found.motion.s_m)} points")


def _prediction_row(found: Prediction) -> list[str]:
    import math

    from labrig.report.parts.table import fixed

    return [
        found.configuration,
        f"{1e3 * found.position_m:g}",
        f"{found.voltage_V:+g}",
        fixed(1e3 * found.F_N, 3),
        fixed(1e3 * found.N_N, 3),
        fixed(1e3 * found.s_hat_m, 2),
        fixed(math.degrees(found.phi_hat_rad), 2),
        found.why or "-",
    ]


COMMAND = Command(
    "simulate",
    simulate,
    order=150,
    examples=(
        CommandExample(
            line="labrig simulate model.toml --configuration long --position-mm 12 --voltage 2"
        ),
    ),
)
