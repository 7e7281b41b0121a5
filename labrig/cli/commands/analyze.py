"""Forces and neutral curves of a session."""

from __future__ import annotations

from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.options import Json, Recorded
from labrig.cli.screen import print_json, print_table, progress, warn


def analyze(
    session: Recorded,
    as_json: Json = False,
    extractor: Annotated[
        str | None,
        typer.Option(
            help="a curve extractor of labrig parts extractors; default: the built-in one"
        ),
    ] = None,
) -> None:
    """Measure a session's forces and neutral curves.

    They are stored in the session.

    Measurements that it holds already are replaced; the recording is never changed.
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


COMMAND = Command(
    "analyze",
    analyze,
    order=130,
    examples=(CommandExample(line="labrig analyze session.h5"),),
)
