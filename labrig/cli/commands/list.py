"""The sessions of a folder."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labrig.cli.command import Command
from labrig.cli.options import Json
from labrig.cli.screen import print_json, print_table, progress, say

if TYPE_CHECKING:
    from labrig.library import CatalogueEntry


def list_sessions(
    folder: Annotated[Path, typer.Argument(help="looked through with all below it")] = Path(),
    sort: Annotated[
        str, typer.Option(help="started, name, outcome, B_Nm2, EIBM_Nm, largest_force_mN, ...")
    ] = "started",
    up: Annotated[bool, typer.Option("--up", help="the smallest or oldest first")] = False,
    text: Annotated[
        str, typer.Option(help="words in name, protocol, people, sample or notes")
    ] = "",
    outcome: Annotated[str, typer.Option(help="completed, aborted, failed, crashed, running")] = "",
    sheet: Annotated[str, typer.Option(help="a configuration, such as long")] = "",
    as_json: Json = False,
) -> None:
    """List the sessions of a folder: date, sheet, outcome, B, EIBM, figures of merit.

    Each file is looked into once; after that only those that have changed. B and EIBM are those of
    the newest model file in the folder that was fitted to the session (labrig fit -o).
    """
    from labrig.library import Library, select

    library = Library(folder)
    with progress("list") as advance:
        library.refresh(advance=advance)
    found = select(
        library.entries(), sort=sort, down=not up, text=text, outcome=outcome, sheet=sheet
    )
    if as_json:
        print_json({"sessions": [entry.as_dict() for entry in found]})
        return
    print_table(f"{folder}", _COLUMNS, [_row(entry) for entry in found])
    for entry in found:
        if entry.error:
            say(f"{entry.name}: {entry.error}")


_COLUMNS = (
    "session", "begun", "sheet", "sample", "outcome", "runs", "readings", "largest mN",
    "scatter mN", "B nN m2", "EIBM uN m",
)  # fmt: skip


def _row(entry: CatalogueEntry) -> list[str]:
    if entry.error:
        return [entry.name, "-", "-", "-", "cannot be read", *["-"] * (len(_COLUMNS) - 5)]
    return [
        entry.name,
        entry.started[:16].replace("T", " ") or "-",
        ", ".join(entry.sheet) or "-",
        entry.sample or "-",
        entry.outcome,
        f"{entry.runs_complete} of {entry.runs}",
        str(entry.readings),
        _number(entry.largest_force_mN, 1.0, 2),
        _number(entry.scatter_mN, 1.0, 3),
        _number(entry.fitted("B_Nm2"), 1e9, 1),
        _number(entry.fitted("EIBM_Nm"), 1e6, 2),
    ]


def _number(value: float | None, times: float, digits: int) -> str:
    return "-" if value is None else f"{times * value:.{digits}f}"


COMMAND = Command("list", list_sessions, order=120)
