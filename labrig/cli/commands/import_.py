"""A session made of tables."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.options import Columns, Ignored, Values
from labrig.cli.screen import print_table, say, warn
from labrig.errors import BadInputError
from labrig.files import typed

if TYPE_CHECKING:
    from labrig.session.tables.csv_rows import TextTable


def import_tables(
    sheet: Annotated[Path | None, typer.Option(help="sheet.toml")] = None,
    forces: Annotated[
        Path | None, typer.Option(help="a table of forces; without it --curves is needed")
    ] = None,
    curves: Annotated[Path | None, typer.Option(help="a table of neutral curves")] = None,
    signals: Annotated[Path | None, typer.Option(help="a table of signals over time")] = None,
    about: Annotated[
        Path | None, typer.Option(help="about.toml; by default the one beside forces.csv, if any")
    ] = None,
    columns: Columns = None,
    values: Values = None,
    ignore: Ignored = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="the session file to make; without: only look"),
    ] = None,
    yes: Annotated[
        bool, typer.Option("--yes", "-y", help="do not ask whether a table is understood rightly")
    ] = False,
    example: Annotated[
        Path | None,
        typer.Option(metavar="FOLDER", help="write small example tables there, and end"),
    ] = None,
) -> None:
    """Make a session of tables of older measurements.

    Columns are separated by commas, semicolons, tabs or spaces, decimals by points or commas;
    lines above the names of the columns are skipped. The encoding is UTF-8, UTF-16 or Latin-1.
    labrig first prints how it understood each table. Where a table is not written as labrig writes
    it, it asks whether that is right; --yes agrees beforehand, but never to a guess.

    forces: configuration, position_mm, voltage_V, force_mN; also reading, sd_mN and mean_of (where
    force_mN is a mean), time_s, kind, valid, run, approach, mounting, tilt_deg.

    curves: configuration, position_mm, voltage_V, x_mm, y_mm; also point, reading, sigma_mm.

    signals: configuration, position_mm, time_s, drive_V; also force_mN, current_mA.

    A camera_uncertainty.csv in the folder of the curves is read with them.

    Other units are converted where the name states them: force [N], force (gf), x (cm); a position
    in degrees or radians is multiplied by the arc's radius. Other names are stated with --columns,
    and what no column says with --value; --ignore leaves a column out.

    `labrig config columns` explains each column, with its axis and sign.

    Example: labrig import --sheet sheet.toml --forces old.txt --columns force_mN=F -o old.h5
    """
    from labrig.config import load_sheet
    from labrig.session import column_names, import_session
    from labrig.session.tables import read_and_understood
    from labrig.session.tables.exchange import about_text

    if example is not None:
        _write_examples(example)
        return
    if sheet is None or (forces is None and curves is None):
        raise BadInputError("give --sheet, and --forces, --curves or both; or --example FOLDER.")
    asked = sys.stdin.isatty() and not yes
    names = replace(column_names(columns, values, ignore), guesses=asked or output is None)
    if output is None:
        about_text(about, Path(forces or curves or sheet))  # a fault in it is told now
        read_it = read_and_understood(load_sheet(sheet), forces, curves, signals, names=names)
        _show(read_it.tables)
        for text in read_it.measurements.warnings:
            warn(f"warning: {text}")
        return

    def agree(tables: Sequence[TextTable]) -> None:
        _show(tables)
        if not (yes or all(table.as_ours for table in tables)):
            _ask(asked)

    read = import_session(
        sheet, forces, output, curves=curves, signals=signals, about=about, names=names, agree=agree
    )
    for text in read.warnings:
        warn(f"warning: {text}")
    say(f"wrote {output}")


def _write_examples(folder: Path) -> None:
    from labrig.session.tables.examples import CURVES, FORCES, LABVIEW, SHEET, write_examples

    for path in write_examples(folder):
        say(f"wrote {path}")
    with_sheet = f"labrig import --sheet {typed(folder / SHEET)} --forces"
    say(f"Try: {with_sheet} {typed(folder / FORCES)} --curves {typed(folder / CURVES)} -o old.h5")
    say(
        f"Try: {with_sheet} {typed(folder / LABVIEW)} --value configuration=long "
        "--columns position_mm=p --columns voltage_V=U "
        "--columns force_mN=F --columns sd_mN=std --columns mean_of=n"
    )


def _ask(can_be_asked: bool) -> None:
    if not can_be_asked:
        raise BadInputError("look at how the tables were understood; give --yes if it is right.")
    if not typer.confirm("Is this right?", default=False):
        raise BadInputError("nothing was written; state columns with --columns and --value.")


def _show(tables: Sequence[TextTable]) -> None:
    from labrig.session.tables.preview import COLUMNS, heading, remarks, rows

    for table in tables:
        print_table(heading(table), COLUMNS, rows(table))
        for text in remarks(table):
            say(text)


COMMAND = Command(
    "import",
    import_tables,
    order=220,
    examples=(
        CommandExample(
            line="labrig import --sheet sheet.toml --forces forces.csv --curves curves.csv "
            "-o old.h5"
        ),
    ),
)
