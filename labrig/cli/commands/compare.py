"""Other models fitted to the same session: simpler ones at rest, and those of others in time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.options import Json, Recorded
from labrig.cli.screen import print_json, print_table, progress, say, warn
from labrig.cli.sentences.option_names import option_of
from labrig.errors import ArgumentWarning

if TYPE_CHECKING:
    from labrig.api.compare import ModelComparison
    from labrig.report.parts.table import Table


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
        typer.Option(help="of the sheet in time: mass of its rigid elongation per length"),
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
    from labrig.api.compare import compared
    from labrig.report.data.findings import workers

    found = compared(
        session, progress, model=model, static=static, dynamic=dynamic,
        elongation_g_per_m=elongation_g_per_m, processes=workers(),
    )  # fmt: skip
    if as_json:
        print_json(found.to_json())
        return
    _show(found)
    for sentence in found.why_no_dynamic.values():
        say(ArgumentWarning(sentence, "elongation_g_per_m").in_words(option_of))


def _show(found: ModelComparison) -> None:
    from labrig.report.tables.baselines import baseline_table
    from labrig.report.tables.in_time.comparison import dynamic_comparison_table, not_fitted

    tables: list[Table] = [baseline_table(found.static)] if found.static else []
    for table in (*tables, *map(dynamic_comparison_table, found.dynamic)):
        print_table(table.title, table.columns, table.rows)
        say(table.note)
        say()
    for one in found.dynamic:
        for sentence in (*not_fitted(one), *one.missing):
            warn(sentence)


COMMAND = Command(
    "compare",
    compare,
    order=160,
    examples=(CommandExample(line="labrig compare session.h5 --static"),),
)
