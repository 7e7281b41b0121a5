"""The discrepancy between model and measurement."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.diagnosis import diagnosed, keep, known_model, print_diagnosis, promises_kept_in
from labrig.cli.measurements import check_stiffness, of_sessions_or_tables
from labrig.cli.options import (
    Columns,
    CurvesFile,
    ForcesFile,
    Json,
    KnownModel,
    Sessions,
    SheetFile,
    SignalsFile,
    Stiffness,
    Symmetric,
    Values,
)
from labrig.cli.screen import print_json, say, warn
from labrig.errors import BadInputError
from labrig.files import check_free


def diagnose(
    sessions: Sessions = None,
    sheet: SheetFile = None,
    forces: ForcesFile = None,
    curves: CurvesFile = None,
    signals: SignalsFile = None,
    columns: Columns = None,
    values: Values = None,
    model: KnownModel = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="the model file to write, with its effects (TOML)"),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="overwrite the model file")] = False,
    report: Annotated[
        Path | None, typer.Option("--report", help="a folder for the page and its figures")
    ] = None,
    hold_out: Annotated[
        list[str] | None,
        typer.Option(
            metavar="[configuration=NAME,]position=MM", help="leave a position out; repeatable"
        ),
    ] = None,
    symmetric: Symmetric = False,
    without: Annotated[
        list[str] | None,
        typer.Option(metavar="EFFECT", help="an effect that is known to be absent; repeatable"),
    ] = None,
    calibrate: Annotated[
        int, typer.Option(min=0, max=10_000, help="number of simulated sessions for the threshold")
    ] = 0,
    stiffness_Nm2: Stiffness = None,
    as_json: Json = False,
) -> None:  # fmt: skip
    """Find out which effects the model is missing, and where.

    It compares simulation and measurement, and searches a catalogue of effects.

    The diagnosis is stored in the (first) session; labrig report shows it, too.
    """
    from labrig.analysis.holding_out import held_out
    from labrig.experiment.next_measurement.next_protocol import with_protocol
    from model.discrepancy import DiagnoseOptions
    from model.effects import effect

    if output is not None:
        check_free(output, force=force)
    if report is not None and report.exists() and not report.is_dir():
        raise BadInputError(f"{report}: this is a file, a folder is needed.")
    for name in without or ():
        effect(name)  # at once: what follows may take minutes
    check_stiffness(stiffness_Nm2)
    measurements = of_sessions_or_tables(
        sessions, sheet, forces, curves, signals, columns=columns, values=values
    )
    options = DiagnoseOptions(
        symmetric=symmetric,
        calibrate=calibrate,
        model=known_model(model),
        exclude=tuple(without or ()),
        hold_out=held_out(hold_out or [], measurements),
        promised=promises_kept_in(sessions or []),
        stiffness_Nm2=stiffness_Nm2,
    )
    found = diagnosed(measurements, options)
    found = with_protocol(found, measurements, sessions[0] if sessions else None)
    if sessions:
        keep(sessions[0], found)
    written = []
    if output is not None and not found.searched:
        older = "; what is there is older" if output.exists() else ""
        warn(
            f"{output} is not written: there is no model of data that contradict what is"
            f" stated{older}."
        )
    elif output is not None:
        from labrig.model_file import save_model

        save_model(found.model, output)
        written.append(output)
    if report is not None:
        from labrig.report.page.diagnosis import write_diagnosis

        written.append(write_diagnosis(found, report))
    if as_json:
        print_json(found.to_json())
        return
    print_diagnosis(found, sessions[0] if sessions else None)
    for path in written:
        say(f"wrote {path}")


COMMAND = Command(
    "diagnose",
    diagnose,
    order=180,
    examples=(CommandExample(line="labrig diagnose session.h5 -o model+.toml"),),
)
