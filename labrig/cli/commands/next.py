"""The next measurement, which separates two effects."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.diagnosis import diagnosed, known_model
from labrig.cli.dynamic_fit import (
    DynamicFluid,
    DynamicRequest,
    ElongationMass,
    SheetFluid,
    refuse_others,
)
from labrig.cli.dynamic_next import next_in_time
from labrig.cli.measurements import of_sessions_or_tables
from labrig.cli.options import (
    Columns,
    CurvesFile,
    ForcesFile,
    Json,
    KnownModel,
    Sessions,
    SheetFile,
    SignalsFile,
    Symmetric,
    Values,
)
from labrig.cli.screen import print_json, say, warn
from labrig.errors import BadInputError
from labrig.files import check_free, write_text


def next_measurement(
    sessions: Sessions = None,
    between: Annotated[
        tuple[str, str] | None,
        typer.Option(help="two effects to be told apart; default: those of the diagnosis"),
    ] = None,
    sheet: SheetFile = None,
    forces: ForcesFile = None,
    curves: CurvesFile = None,
    signals: SignalsFile = None,
    columns: Columns = None,
    values: Values = None,
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

    Without --between, what the diagnosis of the (first) session proposes; a session that holds none
    is diagnosed first.

    With --dynamic, which further run would determine what of the sheet in time: a table of the 90 %
    intervals now and expected. It fits the session as labrig fit --dynamic does, or takes --model.
    """
    from labrig.experiment.next_measurement.next_protocol import protocol_text
    from labrig.experiment.next_measurement.proposal import proposal
    from labrig.report.data.kept_diagnosis import kept_diagnosis
    from labrig.report.diagnosis.tables import next_sentence
    from model.discrepancy import DiagnoseOptions

    if between is not None and between[0] == between[1]:
        raise BadInputError(f"--between names {between[0]} twice; name two different effects.")
    if output is not None:
        check_free(output, force=force)
    if dynamic:
        refuse_others("next", {
            "--between": between, "--sheet": sheet, "--forces": forces, "--curves": curves,
            "--signals": signals, "--columns": columns, "--value": values,
            "--symmetric": symmetric, "--output": output,
        })  # fmt: skip
        if not sessions:
            raise BadInputError("--dynamic: give a session.")
        request = DynamicRequest(
            sessions=sessions, configurations=[], positions_mm=[], fluid=fluid.value,
            elongation_g_per_m=elongation_g_per_m,
        )  # fmt: skip
        next_in_time(request, model, as_json=as_json)
        return
    measurements = of_sessions_or_tables(
        sessions, sheet, forces, curves, signals, columns=columns, values=values
    )
    options = DiagnoseOptions(symmetric=symmetric, model=known_model(model))
    diagnosis = None
    if sessions and (between is None or (model is None and not symmetric)):
        diagnosis = kept_diagnosis(sessions[0])
        if diagnosis is None and between is None:
            warn(f"{sessions[0]} holds no diagnosis yet, so it is diagnosed first")
            from labrig.api.diagnose import keep_in

            diagnosis = diagnosed(measurements, options)
            keep_in(sessions[0], diagnosis)
    found = proposal(measurements, diagnosis, between, options)
    text = protocol_text(found, measurements, sessions[0] if sessions else None)
    if output is not None:
        write_text(output, text)
    if as_json:
        from labrig.config.base import parse_toml

        print_json({
            "why": found.why, "extra": found.extra, "separation_now": found.separation,
            "separation_expected": found.expected, "minutes": found.minutes,
            "protocol": parse_toml(text, "protocol.toml"),
        })  # fmt: skip
        return
    say(next_sentence(found))
    if output is None:
        say()
        say(text)
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
