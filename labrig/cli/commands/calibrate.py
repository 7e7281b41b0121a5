"""Calibrations: load cell and camera, and the board for the latter."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.screen import print_table, say, warn
from labrig.errors import BadInputError
from labrig.files import check_free, keep_replaced, write_text

if TYPE_CHECKING:
    from labrig.vision import Calibration, CalibrationBoard

Columns = Annotated[int, typer.Option(help="squares across the board")]
Rows = Annotated[int, typer.Option(help="squares down the board")]
SquareMm = Annotated[float, typer.Option("--square-mm", help="side of a square, as printed")]
MarkerMm = Annotated[float, typer.Option("--marker-mm", help="side of a marker; 0: checkerboard")]

BOARD = (12, 9, 5.0, 3.6)  # columns, rows, side of a square and of a marker (mm), where not stated


def load_cell(
    rig: Annotated[Path, typer.Argument(help="rig.toml")],
    weight_mN: Annotated[
        list[float], typer.Option("--weight-mN", help="a dead weight; repeat, 0 included")
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="by default the file rig.toml names")
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="take each weight as hung")] = False,
) -> None:
    """Calibrate the load cell with dead weights, one by one.

    It writes load_cell.toml. The output stays at 0 V. The calibration that is replaced is kept
    under its date.
    """
    from labrig.config.file_kinds import LOAD_CELL, refuse_to_replace
    from labrig.experiment.load_cell_calibration import weigh, write_calibration
    from labrig.experiment.operator import ConsoleOperator, NoOperator
    from labrig.experiment.preflight import plan_of
    from labrig.experiment.rig.wiring import wire

    if not all(map(math.isfinite, weight_mN)):
        raise BadInputError("--weight-mN: a weight must be a finite number of mN.")
    if len(set(weight_mN)) < 2 or len(weight_mN) < 3:
        raise BadInputError(
            "--weight-mN: at least three readings with two different weights are needed, such as "
            "--weight-mN 0 --weight-mN 19.6 --weight-mN 49."
        )
    plan = plan_of(rig)
    path = output or plan.rig.load_cell.calibration
    refuse_to_replace(path, LOAD_CELL)
    check_free(path, force=True)
    operator = NoOperator(warn) if yes else ConsoleOperator(warn)
    found = weigh(wire(plan, operator), plan, [load / 1000 for load in weight_mN], warn)
    rows = [
        [f"{1e3 * load:.2f}", f"{1e3 * volt:+.5f}", f"{1e3 * left:+.4f}"]
        for load, volt, left in zip(found.loads_N, found.volts, found.fit.residuals_N, strict=True)
    ]
    print_table("Dead weights", ["weight mN", "reading mV", "off the line mN"], rows)
    made = found.calibration
    say(
        f"sensitivity {made.sensitivity_V_per_N:.6f} ± {made.sensitivity_sigma_V_per_N:.6f} V/N, "
        f"offset {1e6 * made.offset_V:+.2f} ± {1e6 * made.offset_sigma_V:.2f} µV"
    )
    kept = write_calibration(made, path)
    say(f"wrote {path}" + (f"; the one before is {kept}" if kept else ""))


def camera(
    images: Annotated[
        list[Path], typer.Argument(help="of the board; the first one flat in the sheet's plane")
    ],
    clamp_px: Annotated[
        str, typer.Option("--clamp-px", help="U,V: the pixel where the sheet leaves the clamp")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="the optics.json to make")],
    along_px: Annotated[
        str | None,
        typer.Option("--along-px", help="U,V: a second pixel on the clamped sheet: its direction"),
    ] = None,
    ruler_px: Annotated[
        str | None, typer.Option("--ruler-px", help="U1,V1,U2,V2: no board, two points of a ruler")
    ] = None,
    ruler_mm: Annotated[
        float | None, typer.Option("--ruler-mm", help="distance of the ruler's two points, mm")
    ] = None,
    columns: Columns = BOARD[0],
    rows: Rows = BOARD[1],
    square_mm: SquareMm = BOARD[2],
    marker_mm: MarkerMm = BOARD[3],
) -> None:
    """Calibrate the camera with images of a board or a ruler.

    It finds scale, axes and lens, and writes optics.json. One that is replaced is kept under its
    date; what was stated in it by hand, such as mask_px and tip_px, is taken over and named.

    Print the board with `labrig calibrate board`. One image of it, flat in the sheet's plane, is
    enough; three or more fix the lens better.
    """
    from labrig.config.file_kinds import OPTICS, refuse_to_replace
    from labrig.vision import calibrate_camera, calibrate_ruler, read_image
    from labrig.vision.batch.sources import tell_of_drawings
    from labrig.vision.calibration.drawing import (
        drawing_beside,
        is_drawing,
        write_calibration_image,
    )

    if (ruler_px is None) != (ruler_mm is None):
        raise BadInputError(
            "--ruler-px states where two points of a ruler are, and --ruler-mm how far they are "
            "apart; give both, or none with a board."
        )
    refuse_to_replace(output, OPTICS)
    drawing = drawing_beside(output)
    tell_of_drawings(images)
    photographs = [read_image(path) for path in images if not is_drawing(path)]
    if not photographs:
        raise BadInputError("no photograph was given; labrig's own drawings show no board.")
    clamp = _point(clamp_px, "--clamp-px")
    along = None if along_px is None else _point(along_px, "--along-px")
    if ruler_px is not None and ruler_mm is not None:
        if len(photographs) > 1 or (columns, rows, square_mm, marker_mm) != BOARD:
            raise BadInputError(
                "a ruler is read in one photograph and needs no board: leave further images, "
                "--columns, --rows, --square-mm and --marker-mm out."
            )
        u1, v1, u2, v2 = _numbers(ruler_px, "--ruler-px", 4)
        size = (photographs[0].shape[1], photographs[0].shape[0])
        found = calibrate_ruler(size, (u1, v1), (u2, v2), ruler_mm, clamp_px=clamp, along_px=along)
    else:
        found = calibrate_camera(
            photographs,
            _board(columns, rows, square_mm, marker_mm),
            clamp_px=clamp,
            along_px=along,
        )
    _report(found, output)
    write_calibration_image(drawing, photographs[0], found.optics)
    fits = "run along the board's" if ruler_px is None else "are 10 mm apart on the ruler"
    say(f"wrote {drawing}: check that its lines {fits}")


def board(
    output: Annotated[Path, typer.Option("--output", "-o", help="the PDF to make")],
    columns: Columns = BOARD[0],
    rows: Rows = BOARD[1],
    square_mm: SquareMm = BOARD[2],
    marker_mm: MarkerMm = BOARD[3],
) -> None:
    """Write the calibration board as a PDF of its true size.

    It has a ruler to check the print.
    """
    from labrig.config.file_kinds import PDF, refuse_to_replace
    from labrig.vision import write_board_pdf

    refuse_to_replace(output, PDF)
    write_board_pdf(output, _board(columns, rows, square_mm, marker_mm))
    say(f"wrote {output}; print it at 100 % and measure the ruler on it")


def _board(columns: int, rows: int, square_mm: float, marker_mm: float) -> CalibrationBoard:
    from labrig.vision import CalibrationBoard

    return CalibrationBoard(columns, rows, square_mm, marker_mm)


def _point(text: str, option: str) -> tuple[float, float]:
    u, v = _numbers(text, option, 2)
    return u, v


def _numbers(text: str, option: str, count: int) -> list[float]:
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count:
        raise BadInputError(f"{option} {text!r}: {count} numbers with commas between are needed.")
    return values


def _report(found: Calibration, output: Path) -> None:
    from labrig.vision.calibration.carried import carried_over

    carried = carried_over(found.optics, output)
    optics = carried.optics
    say(f"{optics.px_per_mm:.4f} ± {optics.px_per_mm_sigma:.4f} pixels per mm")
    if found.residual_px:
        say(
            f"corners fit with {found.residual_px:.3f} pixels RMS ({found.residual_um:.1f} µm; at "
            f"most {found.largest_um:.1f} µm)"
        )
    for text in found.warnings:
        warn(f"warning: {text}")
    text = optics.model_dump_json(indent=2, exclude_none=True) + "\n"
    kept = keep_replaced(output, text)
    write_text(output, text)
    say(f"wrote {output}" + (f"; the one before is {kept}" if kept else ""))
    if carried.told:
        say(carried.told)


_app = typer.Typer(help="Calibrate what measures.", no_args_is_help=True)
_app.command(name="load-cell")(load_cell)
_app.command()(camera)
_app.command()(board)
COMMAND = Command(
    "calibrate",
    _app,
    order=260,
    examples=(
        CommandExample(
            line="labrig calibrate load-cell rig/rig.toml --weight-mN 0 --weight-mN 49 "
            "--weight-mN 0 --yes"
        ),
        CommandExample(
            line="labrig calibrate camera strip.png --ruler-px 24,75,144,75 --ruler-mm 30 "
            "--clamp-px 24,75 -o optics.json"
        ),
        CommandExample(line="labrig calibrate board -o board.pdf"),
    ),
)
