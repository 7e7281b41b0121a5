"""The next measurement, which separates two effects."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.diagnosis import known_model
from labrig.cli.dynamic_fit import (
    DynamicFluid,
    DynamicRequest,
    ElongationMass,
    SheetFluid,
    print_next_in_time,
    refuse_others,
)
from labrig.cli.measurements import of_sessions_or_tables
from labrig.cli.options import (
    Columns,
    CurvesFile,
    ForcesFile,
    Ignored,
    Json,
    KnownModel,
    Sessions,
    SheetFile,
    SignalsFile,
    Symmetric,
    Values,
)
from labrig.cli.screen import print_json, progress, say
from labrig.errors import BadInputError
from labrig.files import check_free, write_text


def _two_effects(between: tuple[str, str] | None) -> tuple[str, str] | None:
    """Return two names; an option in place of the second one would leave it to the sessions."""
    if between is not None and between[1].startswith("-"):
        raise BadInputError(
            f"--between {between[0]}: name two effects, such as --between gravity clamp_angle."
        )
    return between


def next_measurement(
    sessions: Sessions = None,
    between: Annotated[
        tuple[str, str] | None,
        typer.Option(
            callback=_two_effects,
            is_eager=True,
            help="two effects to be told apart; default: those of the diagnosis",
        ),
    ] = None,
    sheet: SheetFile = None,
    forces: ForcesFile = None,
    curves: CurvesFile = None,
    signals: SignalsFile = None,
    columns: Columns = None,
    values: Values = None,
    ignore: Ignored = None,
    model: KnownModel = None,
    symmetric: Symmetric = False,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="the protocol.toml to write")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="overwrite the protocol")] = False,
    dynamic: Annotated[
        bool,
        typer.Option(
            "--dynamic",
            help="for the sheet in time instead: what a release, a chirp, a step of"
            " the load cell or another position would determine",
        ),
    ] = False,
    fluid: DynamicFluid = SheetFluid.AIR,
    elongation_g_per_m: ElongationMass = None,
    as_json: Json = False,
) -> None:
    """Say which measurement tells two effects apart.

    It writes the protocol of that measurement.

    Without --between, it is the one that the diagnosis of the (first) session proposes; a session
    without a diagnosis is diagnosed first, and so are tables.

    With --dynamic, it prints which further run would determine which parameter of the sheet in
    time: the 90 % intervals now and expected. It fits the session as labrig fit --dynamic does, or
    takes --model.
    """
    from labrig.api.next_measurement import proposed, require_two
    from labrig.report.diagnosis.tables import next_sentence
    from model.discrepancy import DiagnoseOptions

    require_two(between)
    if output is not None:
        check_free(output, force=force)
    if dynamic:
        refuse_others("next", {
            "--between": between, "--sheet": sheet, "--forces": forces, "--curves": curves,
            "--signals": signals, "--columns": columns, "--value": values, "--ignore": ignore,
            "--symmetric": symmetric, "--output": output,
        })  # fmt: skip
        if not sessions:
            raise BadInputError("--dynamic: give a session.")
        request = DynamicRequest(
            sessions=sessions, configurations=[], positions_mm=[], fluid=fluid.value,
            elongation_g_per_m=elongation_g_per_m,
        )  # fmt: skip
        print_next_in_time(request, model, as_json=as_json)
        return
    measurements = of_sessions_or_tables(
        sessions,
        sheet,
        forces,
        curves,
        signals,
        columns=columns,
        values=values,
        ignore=ignore,
    )
    options = DiagnoseOptions(symmetric=symmetric, model=known_model(model))
    with progress("diagnose") as advance:
        found = proposed(measurements, sessions or [], between, options, advance)
    if output is not None:
        write_text(output, found.protocol)
    if as_json:
        print_json(found.to_json())
        return
    say(next_sentence(found.proposal))
    if output is None:
        say()
        say(found.protocol)
    else:
        say(f"wrote {output}")


COMMAND = Command(
    "next",
    next_measurement,
    order=190,
    examples=(
        CommandExample(
            line="labrig next session.h5 --model model+.toml --between gravity clamp_angle "
            "-o next.toml"
        ),
    ),
)
