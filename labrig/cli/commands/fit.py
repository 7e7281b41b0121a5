"""labrig fit: the model's parameters from one session or several."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.dynamic_fit import (
    DynamicFluid,
    DynamicPositions,
    DynamicRequest,
    ElongationMass,
    SheetFluid,
    print_fit_in_time,
    refuse_others,
    refuse_without_dynamic,
)
from labrig.cli.measurements import (
    check_stiffness,
    of_sessions_or_tables,
    warn_of_suspicions,
)
from labrig.cli.model_errors import errors_of, warn_of_misses
from labrig.cli.options import (
    Columns,
    CurvesFile,
    FigureFormats,
    ForcesFile,
    Ignored,
    Json,
    Sessions,
    SheetFile,
    SignalsFile,
    Stiffness,
    Values,
)
from labrig.cli.screen import print_json, print_table, progress, say
from labrig.errors import BadInputError
from labrig.files import check_free

if TYPE_CHECKING:
    from labrig.report.parts.table import Table
    from labrig.report.tables.mountings import Run
    from model import Fit, Measurements


def fit(
    sessions: Sessions = None,
    sheet: SheetFile = None,
    forces: ForcesFile = None,
    curves: CurvesFile = None,
    signals: SignalsFile = None,
    columns: Columns = None,
    values: Values = None,
    ignore: Ignored = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="the model file to write (TOML)")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="overwrite the model file")] = False,
    varying: Annotated[
        bool | None,
        typer.Option(
            "--varying/--constant",
            help="write the model with the EIBM along the sheet, or the constant one",
            show_default=False,
        ),
    ] = None,
    figures: Annotated[Path | None, typer.Option(help="a folder for figures 8 and 9")] = None,
    formats: FigureFormats = None,
    configuration: Annotated[
        list[str] | None, typer.Option(help="fit this one alone; repeatable")
    ] = None,
    hold_out: Annotated[
        list[str] | None,
        typer.Option(
            metavar="[configuration=NAME,]position=MM",
            help="leave a position out, and predict it; repeatable",
        ),
    ] = None,
    apart: Annotated[
        bool,
        typer.Option(
            "--apart", help="give each session B and EIBM of its own, as configuration@FILE"
        ),
    ] = False,
    by_run: Annotated[
        bool,
        typer.Option("--by-run", help="also print B and EIBM of each set-up (not with --json)"),
    ] = False,
    symmetric: Annotated[
        bool, typer.Option("--symmetric", help="one |EIBM| for both polarities")
    ] = False,
    measured_curvature: Annotated[
        bool,
        typer.Option(
            "--measured-curvature", help="k0 from the curves at 0 V, whatever sheet.toml states"
        ),
    ] = False,
    bootstrap: Annotated[
        int,
        typer.Option(
            min=0, max=10_000, help="number of simulated repeats that check the uncertainties"
        ),
    ] = 0,
    q: Annotated[float, typer.Option(help="weight exponent q of (7)")] = 1.0,
    stiffness_Nm2: Stiffness = None,
    dynamic: Annotated[
        bool,
        typer.Option(
            "--dynamic", help="the sheet in time instead: also mass, loss, electrodes (dynamics.md)"
        ),
    ] = False,
    position_mm: DynamicPositions = None,
    fluid: DynamicFluid = SheetFluid.AIR,
    elongation_g_per_m: ElongationMass = None,
    as_json: Json = False,
) -> None:
    """Identify bending stiffness and EIBM of a session's sheets.

    EIBM is the electrically induced bending moment.

    Sessions of the same sheet share them, unless --apart is given. Tables of older measurements
    need no session: --sheet with --forces, --curves or both (labrig import explains them).

    The model file holds the model with constant EIBM, or that with the EIBM along the sheet where
    the constant one misses the data; --varying and --constant say which.

    With --dynamic, from the runs as they were recorded, force, current and every frame over time:
    relaxed stiffness, mass, loss, electrodes and moment per volt, each with its 90 % interval, how
    much of its variance is the prior's, or which measurement would determine it. Mass and loss need
    a free sheet that moves ([extras] release = true), the rest pulses in contact. The model file
    holds the sheet in time, for simulate --time, response and control.
    """
    from labrig.api.fit import fitted_data
    from labrig.files import make_folder
    from labrig.model_file import check_name
    from labrig.report.data.findings import workers
    from labrig.report.figures.fit import write_fit_figures
    from labrig.report.parts.style import known_formats

    if output is not None:
        check_name(output)
        check_free(output, force=force)
    tables = {
        "--sheet": sheet, "--forces": forces, "--curves": curves, "--signals": signals,
        "--columns": columns, "--value": values, "--ignore": ignore,
    }  # fmt: skip
    in_time = DynamicRequest(
        sessions=sessions or [], configurations=configuration or [], positions_mm=position_mm or [],
        fluid=fluid.value, elongation_g_per_m=elongation_g_per_m,
    )  # fmt: skip
    if dynamic:
        at_rest = {
            "--varying or --constant": varying is not None, "--figures": figures,
            "--format": formats, "--hold-out": hold_out, "--apart": apart, "--by-run": by_run,
            "--symmetric": symmetric, "--measured-curvature": measured_curvature,
            "--bootstrap": bootstrap, "--q": q != 1.0, "--stiffness-Nm2": stiffness_Nm2,
        }  # fmt: skip
        refuse_others("fit", tables | at_rest)
        print_fit_in_time(in_time, output, as_json=as_json)
        return
    refuse_without_dynamic(in_time)
    check_stiffness(stiffness_Nm2)
    wanted = known_formats(formats)
    if figures is not None:
        make_folder(figures)
    if not sessions and (apart or by_run):
        raise BadInputError("--apart and --by-run compare sessions; give sessions with them.")
    source: Measurements | list[Path] = sessions or []
    if not sessions or any(tables.values()):
        source = of_sessions_or_tables(
            sessions,
            sheet,
            forces,
            curves,
            signals,
            columns=columns,
            values=values,
            ignore=ignore,
        )
    with progress("analyze") as advance:
        data = fitted_data(
            source, configuration=configuration or (), hold_out=hold_out or (), apart=apart,
            symmetric=symmetric, measured_curvature=measured_curvature, bootstrap=bootstrap, q=q,
            stiffness_Nm2=stiffness_Nm2, progress=advance, processes=workers(),
        )  # fmt: skip
    found, measurements = data.fit, data.measurements
    suspicious = warn_of_suspicions(measurements)
    written = [] if output is None else [_save(found, output, varying=varying)]
    if figures is not None:
        written += write_fit_figures(figures, found, measurements, wanted)
    if as_json:
        print_json({**found.to_json(), "data_checks": [one.to_json() for one in suspicious]})
        return
    _print(found, measurements, data.runs if by_run else None)
    if output is not None and varying is None and found.preferred_model is found.varying_model:
        say(f"{output} holds the EIBM along the sheet: with a constant one the model misses.")
    for path in written:
        say(f"wrote {path}")


def _save(found: Fit, output: Path, *, varying: bool | None) -> Path:
    """Write the model that was asked for, and warn where it misses the data."""
    from labrig.model_file import save_model

    chosen = {None: found.preferred_model, True: found.varying_model, False: found.model}
    save_model(chosen[varying], output, force=True)
    warn_of_misses(errors_of(chosen[varying], found.configurations))
    return output


def _print(fit: Fit, measurements: Measurements, sessions: dict[Run, str] | None) -> None:
    """Print the whole fit; with `sessions` each set-up, too."""
    from labrig.report.tables.fit import trust

    for table in _tables(fit, measurements, sessions):
        print_table(table.title, table.columns, table.rows)
        if table.note:
            say(table.note)
            say()
    for text in trust(fit):
        say(text)


def _tables(fit: Fit, measurements: Measurements, sessions: dict[Run, str] | None) -> list[Table]:
    from labrig.report.tables.cross_validation import left_out_rows, left_out_table
    from labrig.report.tables.fit import repeats_table, scatter_table
    from labrig.report.tables.paper import compared_conditions, table_4, table_5, table_6

    fitted = [c for c in measurements.conditions if not fit.options.holds_out(c)]
    compared = compared_conditions(replace(measurements, conditions=tuple(fitted)), fit)
    tables = [table_4(fit)]
    if compared:
        tables.append(table_5(fit, compared))
    tables.append(table_6(fit))
    if sessions is not None:
        from labrig.report.tables.mountings import by_run_table
        from model.identification.mounting import by_run

        tables.append(by_run_table(fit, by_run(fit.joint), sessions))
    rows = left_out_rows(fit, measurements)
    if rows:
        tables.append(left_out_table(rows))
    tables.append(scatter_table(fit))
    repeats = repeats_table(fit)
    return tables if repeats is None else [*tables, repeats]


COMMAND = Command(
    "fit",
    fit,
    order=140,
    examples=(CommandExample(line="labrig fit session.h5 -o model.toml"),),
)
