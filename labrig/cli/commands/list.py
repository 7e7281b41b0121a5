"""The sessions of a folder."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.options import Json
from labrig.cli.screen import print_json, print_table, progress, say, warn
from labrig.errors import BadInputError
from labrig.report.parts.table import fixed, volts

if TYPE_CHECKING:
    from labrig.library import CatalogueEntry

_MOST_LINES = 500  # that anybody reads on a screen


def list_sessions(
    folder: Annotated[
        Path, typer.Argument(help="a folder, searched with all folders in it")
    ] = Path(),
    sort: Annotated[
        str, typer.Option(help="started, name, outcome, B_Nm2, EIBM_Nm, largest_force_mN, ...")
    ] = "started",
    up: Annotated[bool, typer.Option("--up", help="the smallest or oldest first")] = False,
    text: Annotated[
        str, typer.Option(help="words in name, protocol, people, sample or notes")
    ] = "",
    outcome: Annotated[str, typer.Option(help="completed, aborted, failed, crashed, running")] = "",
    sheet: Annotated[str, typer.Option(help="a configuration, such as long")] = "",
    limit: Annotated[
        int | None,
        typer.Option(min=0, help=f"at most so many; {_MOST_LINES}, with --json all; 0: all"),
    ] = None,
    offset: Annotated[int, typer.Option(min=0, help="leave out the first so many")] = 0,
    as_json: Json = False,
) -> None:
    """List the sessions of a folder, and what was found.

    Date, sheet, outcome, B, EIBM and figures of merit.

    Each file is read once, and again when it has changed. B and EIBM are from the newest model file
    in the folder that labrig fit -o wrote for the session; where there is none, from the newest one
    of labrig diagnose -o. One beside the session comes before those in other folders. The file and
    the kind of EIBM are named beside them.
    """
    from labrig.library import Library, SessionQuery
    from protocols.execution.events import Outcome

    if outcome and outcome not in set(Outcome):
        raise BadInputError(f"--outcome {outcome}: give {', '.join(Outcome)}.")
    most = limit if limit is not None else (0 if as_json else _MOST_LINES)
    wanted = SessionQuery(
        sort=sort, down=not up, text=text, outcome=outcome, sheet=sheet,
        limit=most or None, offset=offset,
    )  # fmt: skip
    library = Library(folder)
    with progress("list") as advance:
        library.refresh(advance=advance)
    found = library.find(wanted)
    if library.cut:
        warn(library.cut)
    if as_json:
        sessions = [entry.as_dict() for entry in found.entries]
        print_json({"sessions": sessions, "total": found.total})
        return
    print_table(f"{folder}", _COLUMNS, [_row(entry) for entry in found.entries])
    if any(entry.fit for entry in found.entries):
        say(_NOTE)
    if not found.entries:
        say(_why_none(found.total, chosen=bool(text or outcome or sheet)))
    elif len(found.entries) < found.total:
        last = offset + len(found.entries)
        say(f"These are {offset + 1} to {last} of {found.total}; see --limit, --offset and --text.")
    for entry in found.entries:
        if entry.error:
            say(f"{entry.name}: {entry.error}")
        elif outdated := _outdated(entry):
            say(f"{entry.name}: {outdated} out of date: runs or readings were marked since.")


def _why_none(total: int, *, chosen: bool) -> str:
    if total:
        return f"There are {total} in all; --offset leaves them out."
    if chosen:
        return "No session fits --text, --outcome and --sheet."
    return "There is no session in this folder, nor in the folders in it."


def _outdated(entry: CatalogueEntry) -> str:
    found = {"analysis": entry.analysis_outdated, "fit": entry.fit_outdated}
    return " and ".join(name for name, is_outdated in found.items() if is_outdated)


_COLUMNS = (
    "session", "started", "sheet", "sample", "outcome", "runs", "readings", "largest force, mN",
    "scatter, mN", "B, µN·m²", "EIBM, µN·m", "kind of EIBM", "model file",
)  # fmt: skip
_NOTE = (
    "Largest force: change from 0 V. B and EIBM: of the first sheet in the model file, EIBM at the"
    " voltage where it is largest."
)


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
        fixed(entry.largest_force_mN, 2),
        fixed(entry.scatter_mN, 3),
        *_fitted(entry),
    ]


def _fitted(entry: CatalogueEntry) -> list[str]:
    """Return B and EIBM of the first sheet that was fitted, and what they are."""
    name, fit = next(iter((entry.fit or {}).items()), ("", None))
    if fit is None:
        return ["-"] * 4
    voltage, moment = max(fit["EIBM_Nm"].items(), key=lambda item: abs(item[1]))
    return [
        f"{name}: {1e6 * fit['B_Nm2']:.4g}",
        f"{name}, {volts(float(voltage))}: {1e6 * moment:.4g}",
        fit["EIBM_quantity"],
        fit["model"],
    ]


COMMAND = Command(
    "list",
    list_sessions,
    order=120,
    examples=(CommandExample(line="labrig list ."),),
)
