"""Simpler models fitted to the same session."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command
from labrig.cli.measurements import fitted_of
from labrig.cli.options import Json, Recorded
from labrig.cli.screen import print_json, print_table, progress, say, warn


def compare(
    session: Recorded,
    model: Annotated[Path | None, typer.Option(help="a model file to compare as it is")] = None,
    as_json: Json = False,
) -> None:
    """Compare simpler models with that of large deflections and an EIBM along the sheet.

    Each simpler model is fitted to the session. A model file of labrig fit or labrig diagnose is
    compared as it is.
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


COMMAND = Command("compare", compare, order=160)
