"""The discrepancy between model and measurement."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.diagnosis import print_diagnosis
from labrig.cli.measurements import check_stiffness, of_sessions_or_tables
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
    Stiffness,
    Symmetric,
    Values,
)
from labrig.cli.screen import print_json, progress, say, warn
from labrig.files import check_free


def diagnose(
    sessions: Sessions = None,
    sheet: SheetFile = None,
    forces: ForcesFile = None,
    curves: CurvesFile = None,
    signals: SignalsFile = None,
    columns: Columns = None,
    values: Values = None,
    ignore: Ignored = None,
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
    most_effects: Annotated[
        int | None,
        typer.Option(min=1, max=10, help="names to look for, 3 by default; more may take minutes"),
    ] = None,
    stiffness_Nm2: Stiffness = None,
    as_json: Json = False,
) -> None:  # fmt: skip
    """Find out which effects the model is missing, and where.

    It compares simulation and measurement, and searches a catalogue of effects.

    The diagnosis is stored in the (first) session; labrig report shows it, too.
    """
    from labrig.api.diagnose import diagnosed_and_kept, options_for
    from labrig.model_file import check_name
    from model.effects import effect

    if output is not None:
        check_name(output)
        check_free(output, force=force)
    if report is not None:
        from labrig.report.page.diagnosis import check_folder, write_diagnosis

        check_folder(report)
    for name in without or ():
        effect(name)  # at once: what follows may take minutes
    check_stiffness(stiffness_Nm2)
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
    options = options_for(
        measurements, sessions or [], model=model, hold_out=hold_out or (), symmetric=symmetric,
        without=without or (), calibrate=calibrate, most_effects=most_effects,
        stiffness_Nm2=stiffness_Nm2,
    )  # fmt: skip
    with progress("diagnose") as advance:
        found = diagnosed_and_kept(measurements, sessions or [], options, advance)
    written = []
    if output is not None and not found.searched:
        older = "; what is there is older" if output.exists() else ""
        warn(
            f"{output} is not written: there is no model of data that contradict what is"
            f" stated{older}."
        )
    elif output is not None:
        from labrig.model_file import save_model

        save_model(found.model, output, force=True)
        written.append(output)
    if report is not None:
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
