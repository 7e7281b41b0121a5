"""Other models fitted to the same session: simpler ones at rest, and those of others in time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.measurements import fitted_of
from labrig.cli.options import Json, Recorded
from labrig.cli.screen import print_json, print_table, progress, say, warn
from labrig.errors import BadInputError

if TYPE_CHECKING:
    from labrig.analysis.comparison import DynamicComparison
    from labrig.report.parts.table import Table
    from model import Measurements
    from model.identification.baselines import BaselineRow


def compare(
    session: Recorded,
    model: Annotated[Path | None, typer.Option(help="a model file to compare as it is")] = None,
    static: Annotated[
        bool, typer.Option("--static", help="the sheet at rest alone, in seconds")
    ] = False,
    dynamic: Annotated[
        bool, typer.Option("--dynamic", help="the sheet in time alone; an error where it cannot be")
    ] = False,
    elongation_g_per_m: Annotated[
        float | None,
        typer.Option(min=0.0, help="of the sheet in time: mass of its rigid elongation per length"),
    ] = None,
    as_json: Json = False,
) -> None:
    """Compare other models with labrig's, each fitted to the session.

    At rest: simpler models beside that of large deflections and an EIBM along the sheet. A model
    file of labrig fit or labrig diagnose is compared as it is.

    In time, where force, current and a free sheet that moves were recorded ([extras] release =
    true): nine models from the literature beside labrig's moving sheet, by what they predict of
    positions and pulses that were held out and by their evidence. It takes about a minute; the
    session keeps the result, and labrig report shows it.
    """
    if static and dynamic:
        raise BadInputError("give --static or --dynamic, or neither for both.")
    from labrig.report.data.findings import measured

    with progress("analyze") as advance:
        measurements = measured(session, advance, warn)
    rows = () if dynamic else _at_rest(session, measurements, model)
    compared, why_not = ([], {}) if static else _in_time(session, elongation_g_per_m)
    if dynamic and not compared:
        raise BadInputError("; ".join(why_not.values()) or f"{session}: nothing was driven.")
    if as_json:
        from labrig.report.tables.baselines import baselines_as_list

        print_json({
            "static": baselines_as_list(rows), "dynamic": _as_list(compared),
            "why_no_dynamic": why_not,
        })  # fmt: skip
        return
    _show(rows, compared)
    for sentence in why_not.values():
        say(sentence)


def _at_rest(
    session: Path, measurements: Measurements, model: Path | None
) -> tuple[BaselineRow, ...]:
    from dataclasses import replace

    from model import FitOptions
    from model.identification.baselines import compare as compare_models

    fitted = fitted_of(str(session), measurements, FitOptions())
    rows = compare_models(
        measurements, replace(fitted.options, configurations=tuple(fitted.configurations))
    )
    if model is None:
        return rows
    from labrig.model_file import load_model
    from labrig.report.tables.model_file import model_rows

    names = list(fitted.configurations)
    rows = (*rows, *model_rows(measurements, load_model(model), model.name, names))
    return tuple(sorted(rows, key=lambda row: names.index(row.configuration)))


def _in_time(
    session: Path, elongation_g_per_m: float | None
) -> tuple[list[DynamicComparison], dict[str, str]]:
    """Return what was compared and kept, and by configuration why not, a sentence each."""
    from labrig.analysis.comparison import compare_in_time, keep_comparisons, why_not_in_time
    from labrig.analysis.motion.beginning import StatedValues
    from labrig.session import open_session, stored_curve_extractor

    gram = None if elongation_g_per_m is None else 1e-3 * elongation_g_per_m
    stated = StatedValues(elongation_kg_per_m=gram)
    found: list[DynamicComparison] = []
    why_not: dict[str, str] = {}
    extractor = stored_curve_extractor(session).partition(" ")[0]
    with open_session(session) as recorded:
        names = dict.fromkeys(run.planned.configuration for run in recorded.runs if run.started)
        if not names:
            why_not[""] = "Models in time were not compared: the session holds tables alone."
        for name in names:
            if why := why_not_in_time(recorded, name):
                why_not[name] = f"Models in time were not compared for '{name}': {why}"
                continue
            try:
                with progress("compare in time") as advance:
                    found.append(
                        compare_in_time(
                            recorded, name, stated, progress=advance,
                            **({"extractor": extractor} if extractor else {}),
                        )
                    )  # fmt: skip
            except BadInputError as error:
                why_not[name] = f"Models in time were not compared for '{name}': {error}"
    if found:
        keep_comparisons(session, found)
    return found, why_not


def _show(rows: tuple[BaselineRow, ...], compared: list[DynamicComparison]) -> None:
    from labrig.report.tables.baselines import baseline_table
    from labrig.report.tables.in_time.comparison import dynamic_comparison_table, not_fitted

    tables: list[Table] = [baseline_table(rows)] if rows else []
    for table in (*tables, *map(dynamic_comparison_table, compared)):
        print_table(table.title, table.columns, table.rows)
        say(table.note)
        say()
    for found in compared:
        for sentence in (*not_fitted(found), *found.missing):
            warn(sentence)


def _as_list(compared: list[DynamicComparison]) -> list[dict[str, Any]]:
    from dataclasses import asdict

    return [asdict(one) for one in compared]


COMMAND = Command(
    "compare",
    compare,
    order=160,
    examples=(CommandExample(line="labrig compare session.h5 --static"),),
)
