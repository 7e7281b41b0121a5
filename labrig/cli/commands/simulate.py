"""What a model predicts, at rest and in time."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeVar

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.model_errors import say_as_seen, say_errors
from labrig.cli.options import EachConfiguration, Json, ModelFile, OwnEibm, StatedStiffness
from labrig.cli.screen import print_json, print_table, say
from labrig.cli.stated_model import StatedModel
from labrig.errors import BadInputError

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
    eibm: OwnEibm = None,
    stiffness_Nm2: StatedStiffness = None,
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

    All combinations of the stated conditions are predicted.

    With --eibm, the prediction is for EIBMs of your own; --voltage may then be left out. With
    --eibm and --stiffness-Nm2, sheet.toml takes the model file's place.

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
        stated = StatedModel(model, eibm or (), stiffness_Nm2)
        _at_rest(stated, configuration, position_mm, voltage, session, as_json=as_json)
        return
    given = {
        "--voltage": bool(voltage), "--session": session > 0, "--json": as_json,
        "--eibm": bool(eibm), "--stiffness-Nm2": stiffness_Nm2 is not None,
    }  # fmt: skip
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
    _in_time(model, place, (drive, run), (every_ms, start_ms), output)


def _only(values: list[Given] | None) -> Given | None:
    return values[0] if values else None


def _refuse(given: dict[str, bool], why: str) -> None:
    """Raise BadInputError for the first option that is given where it makes no sense."""
    for option, is_given in given.items():
        if is_given:
            raise BadInputError(f"{option} {why}.")


def _at_rest(
    stated: StatedModel,
    configuration: list[str] | None,
    position_mm: list[float] | None,
    voltage: list[float] | None,
    session: int,
    *,
    as_json: bool,
) -> None:
    from labrig.api.simulate import simulate as simulate_at_rest

    found = simulate_at_rest(
        stated.model(), position_mm=position_mm or (), voltage=voltage or stated.voltages,
        configuration=configuration or (), session=session,
    )  # fmt: skip
    if as_json:
        print_json(found.to_json())
        return
    table = found.summary()
    print_table(f"{stated.path}", table.columns, table.rows)
    say_as_seen(found.model)
    say_errors(found.errors, found.model)


def _in_time(
    model: Path,
    place: tuple[str | None, float | None],
    driven: tuple[Path, int | None],
    times_ms: tuple[float, float],
    output: Path,
) -> None:
    from labrig.api.simulate import simulate_in_time
    from labrig.motion.motion_file import require_ending, write_motion
    from labrig.motion.simulated import SUMMARY_COLUMNS, summary_rows

    require_ending(output)
    (configuration, position_mm), (drive, number) = place, driven
    every_ms, start_ms = times_ms
    found = simulate_in_time(
        model, drive, configuration=configuration, position_mm=position_mm, run=number,
        every_ms=every_ms, start_ms=start_ms,
    )  # fmt: skip
    made_from = {"model_file": model.name, "drive_file": drive.name}
    write_motion(found, made_from, output)
    print_table(f"{model}: {found.place}", SUMMARY_COLUMNS, summary_rows(found))
    say(f"wrote {output}: {len(found.motion.time_s)} times, {len(found.motion.s_m)} points")


COMMAND = Command(
    "simulate",
    simulate,
    order=150,
    examples=(
        CommandExample(
            line="labrig simulate model.toml --configuration long --position-mm 12 --voltage 2"
        ),
        CommandExample(
            line="labrig simulate model.toml --configuration long --position-mm 12 --eibm 2=36e-6"
        ),
    ),
)
