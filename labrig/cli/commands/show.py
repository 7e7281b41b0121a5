"""What a session holds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.options import Json
from labrig.cli.screen import print_json, print_table, say

if TYPE_CHECKING:
    from labrig.report.parts.table import Table


def show(
    session: Annotated[Path, typer.Argument(help="a recorded session, also a running one")],
    compare: Annotated[
        Path | None, typer.Option(help="another session: what differs, dataset by dataset")
    ] = None,
    log: Annotated[bool, typer.Option("--log", help="the event log, line by line")] = False,
    as_json: Json = False,
) -> None:
    """Show what a session holds.

    Outcome, people, sample, runs, readings, losses and notes.
    """
    from labrig.report.tables.about import about_tables, notes_table
    from labrig.report.tables.overview import overview
    from labrig.session import compare_sessions, open_session

    if compare is not None:
        differences = compare_sessions(session, compare)
        if as_json:
            print_json({"equal": not differences, "differences": differences})
        else:
            say("\n".join(differences) or "the sessions are equal")
        return
    with open_session(session, live=True) as opened:
        found, about, notes = overview(opened), opened.about, opened.notes
    if as_json:
        stated = {"about": about.model_dump(mode="json"), "notes": [note.head for note in notes]}
        print_json({**found.as_dict(), **stated})
        return
    for table in (*found.tables(log=log), *about_tables(about), *_if_any(notes_table(notes))):
        print_table(table.title, table.columns, table.rows)


def _if_any(table: Table) -> list[Table]:
    return [table] if table.rows else []


COMMAND = Command(
    "show",
    show,
    order=80,
    examples=(CommandExample(line="labrig show session.h5"),),
)
