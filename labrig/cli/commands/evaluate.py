"""What comes of a session: analyze, fit, simulate, compare, report."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labrig.cli.commands.fit import fit, fitted_of
from labrig.cli.screen import print_json, print_table, progress, say, warn
from labrig.errors import BadInputError

if TYPE_CHECKING:
    from model import Prediction

Recorded = Annotated[Path, typer.Argument(help="a recorded session")]
Json = Annotated[bool, typer.Option("--json", help="print one JSON object")]


def add_to(app: typer.Typer) -> None:
    """Add these commands."""
    for command in (analyze, fit, simulate, compare, report):
        app.command()(command)


def analyze(
    session: Recorded,
    as_json: Json = False,
    extractor: Annotated[
        str | None, typer.Option(help="name of a curve extractor; default: the built-in one")
    ] = None,
) -> None:
    """Measure forces and neutral curves, and keep them in the session.

    Measurements that it holds already are replaced; what was recorded is never changed.
    """
    from labrig.analysis import analyze as analyze_session
    from labrig.extractors.choice import BUILT_IN
    from labrig.report.data.findings import workers
    from labrig.report.tables.measurements import measurements_as_dict, measurements_tables

    with progress("analyze") as advance:
        found = analyze_session(
            session, advance, workers=workers(), extractor=extractor or BUILT_IN
        )
    if as_json:
        print_json(measurements_as_dict(found))
        return
    for table in measurements_tables(found):
        print_table(table.title, table.columns, table.rows)
    for text in found.warnings:
        warn(text)


def simulate(
    model: Annotated[Path, typer.Argument(help="a model file, as labrig fit writes it")],
    configuration: Annotated[
        list[str] | None, typer.Option(help="repeatable; by default all that the model has")
    ] = None,
    position_mm: Annotated[
        list[float] | None, typer.Option(help="along the arc; repeatable")
    ] = None,
    voltage: Annotated[list[float] | None, typer.Option(help="in V; repeatable")] = None,
    as_json: Json = False,
) -> None:
    """Force and shape that a model predicts, for all combinations of what is given."""
    from labrig.model_file import load_model
    from model import predict

    if not position_mm or not voltage:
        raise BadInputError("give at least one --position-mm and one --voltage.")
    known = load_model(model)
    found = [
        predict(known, name, 1e-3 * position, volts)
        for name in configuration or known.sheets
        for position in position_mm
        for volts in voltage
    ]
    if as_json:
        print_json([one.to_json() for one in found])
        return
    columns = ["sheet", "p mm", "V", "F mN", "N mN", "contact at mm", "angle deg", "remark"]
    print_table(f"{model}", columns, [_prediction_row(one) for one in found])


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


def compare(
    session: Recorded,
    model: Annotated[
        Path | None, typer.Option(help="a model file to be compared too, as it stands")
    ] = None,
    as_json: Json = False,
) -> None:
    """Fit simpler models to a session too: what large deflection and a varying EIBM are worth.

    A model file, such as labrig diagnose writes it, is not fitted but compared as it stands.
    """
    from dataclasses import replace

    from labrig.report.data.findings import measured
    from labrig.report.tables.baselines import baseline_table, baselines_as_list
    from model import FitOptions
    from model.identification.baselines import compare as compare_models

    with progress("analyze") as advance:
        measurements = measured(session, advance, warn)
    fitted = fitted_of(str(session), measurements, FitOptions())
    rows = compare_models(
        measurements, replace(fitted.options, configurations=tuple(fitted.configurations))
    )
    if model is not None:
        from labrig.model_file import load_model
        from labrig.report.tables.model_file import model_rows

        names = list(fitted.configurations)
        rows = (*rows, *model_rows(measurements, load_model(model), model.name, names))
        rows = tuple(sorted(rows, key=lambda row: names.index(row.configuration)))
    if as_json:
        print_json(baselines_as_list(rows))
        return
    table = baseline_table(rows)
    print_table(table.title, table.columns, table.rows)
    say(table.note)


def report(
    session: Recorded,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="the folder to write into; default NAME-report"),
    ] = None,
) -> None:
    """Write tables, figures and one self-contained page about a session."""
    from labrig.report.page.write import write_report

    with progress("report") as advance:
        page = write_report(session, output, progress=advance, tell=warn)
    say(f"wrote {page}")
