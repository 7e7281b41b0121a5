"""How a sheet answers a voltage in time: step, Bode plot, tables."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.options import FigureFormats, ModelFile
from labrig.cli.screen import print_table, say
from labrig.errors import BadInputError

_OF_FILES = (".csv", ".png", ".svg", ".pdf", ".h5", ".toml", ".json")


class Driven(StrEnum):
    """What drives the sheet."""

    VOLTAGE = "voltage"


class Answered(StrEnum):
    """What answers."""

    FORCE = "force"
    TIP = "tip"
    CURRENT = "current"


def response(
    model: ModelFile,
    input_: Annotated[  # noqa: ARG001 - the only one there is
        Driven, typer.Option("--input", help="what drives the sheet")
    ] = Driven.VOLTAGE,
    output: Annotated[Answered, typer.Option(help="what answers")] = Answered.FORCE,
    configuration: Annotated[
        str | None, typer.Option(help="needed where the model has several")
    ] = None,
    position_mm: Annotated[
        float | None, typer.Option(help="of the load cell; without it the sheet is free")
    ] = None,
    folder: Annotated[Path, typer.Option("--folder", "-o", help="for figure and tables")] = Path(
        "response"
    ),
    formats: FigureFormats = None,
) -> None:
    """Compute a step and a Bode plot about rest at 0 V.

    The small-signal response is drawn, and written as CSV tables. The moment per volt is the mean
    of those for positive and negative voltages.

    Writes OUTPUT.png and .svg, OUTPUT_step.csv and OUTPUT_bode.csv into the folder.
    """
    from labrig.control.sheet_loop import linear_sheet
    from labrig.report.figures.response import Response, response_figure
    from labrig.report.parts.style import known_formats, save_all

    wanted = known_formats(formats)
    if folder.suffix.lower() in _OF_FILES and not folder.is_dir():
        raise BadInputError(
            f"-o is a folder: {folder} would hold a figure and two tables; leave out"
            f" {folder.suffix}."
        )
    if output is Answered.FORCE and position_mm is None:
        raise BadInputError("a free sheet presses on nothing: give --position-mm for the force.")
    place = None if position_mm is None else 1e-3 * position_mm
    sheet = linear_sheet(model, configuration, place)
    found = Response.of(sheet.system, output.value)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInputError(f"{folder}: cannot be made ({error.strerror}).") from None
    figures = save_all(response_figure(found), folder, output.value, wanted)
    tables = found.write_tables(folder)
    rows = [["gain at rest", f"{found.gain_at_rest:.4g} {found.unit}/V"]]
    rows += [["-3 dB at", f"{found.bandwidth_hz:.3g} Hz"]] if found.bandwidth_hz else []
    rows += [
        [f"mode {number}", f"{mode.frequency_hz:.4g} Hz, damping ratio {mode.damping:.2g}"]
        for number, mode in enumerate(found.modes, 1)
    ]
    where = "free" if position_mm is None else f"at {position_mm:g} mm"
    print_table(f"{output.value}, {sheet.sheet.configuration}, {where}", ["figure", "value"], rows)
    for path in (*figures, *tables):
        say(f"wrote {path}")


COMMAND = Command(
    "response",
    response,
    order=153,
    examples=(CommandExample(line="labrig response dynamic.toml --position-mm 5 -o response"),),
)
