"""What a sheet can do, and which sheet one needs: design."""

from __future__ import annotations

import math
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.model_errors import errors_of, say_errors, warn_of_misses
from labrig.cli.options import EachConfiguration, Json, ModelFile
from labrig.cli.screen import print_json, print_table, say, warn
from labrig.errors import BadInputError


class Direction(StrEnum):
    """In which direction the required force must be possible."""

    BOTH = "both"
    POSITIVE = "positive"
    NEGATIVE = "negative"


def design(
    model: ModelFile,
    section: Annotated[str, typer.Option(help="the working section in mm, such as 0:30")],
    configuration: EachConfiguration = None,
    force_mN: Annotated[
        float | None, typer.Option("--force-mN", help="required throughout: the least area for it")
    ] = None,
    direction: Annotated[
        Direction, typer.Option(help="in which the required force must be possible")
    ] = Direction.BOTH,
    mass_g: Annotated[float, typer.Option("--mass-g", help="of the object on the arc")] = 1.0,
    bandwidth_Hz: Annotated[
        float, typer.Option("--bandwidth-Hz", help="wanted of the controlled object")
    ] = 1.0,
    lag_s: Annotated[float, typer.Option("--lag-s", help="of the voltage's effect")] = 0.0,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="a folder for the figures")
    ] = None,
    as_json: Json = False,
) -> None:
    """Answer the paper's design questions for a section.

    The working section of the arc is that of the paper's section 5.

    Best line and controller, largest difference of shapes, shortest sheet, largest forces, force in
    both directions, and the sheet of least area with and without a rigid elongation. Each question
    is answered by itself; what has no answer is reported with the reason. So is a model that does
    not describe its own data.
    """
    from labrig.model_file import load_model
    from labrig.report.design.answers import Wanted, answer, as_dict, tables

    low_m, high_m = _section(section)
    _check({"--force-mN": force_mN, "--mass-g": mass_g, "--bandwidth-Hz": bandwidth_Hz}, lag_s)
    if output is not None and output.exists() and not output.is_dir():
        raise BadInputError(f"{output}: this is a file, a folder is needed.")
    known = load_model(model)
    answers = [
        answer(
            known,
            Wanted(
                configuration=name,
                low_m=low_m,
                high_m=high_m,
                force_N=None if force_mN is None else force_mN / 1000,
                direction=direction.value,
                mass_kg=mass_g / 1000,
                bandwidth_rad_per_s=2 * math.pi * bandwidth_Hz,
                lag_s=lag_s,
            ),
        )
        for name in configuration or known.sheets
    ]
    errors = errors_of(known, [found.wanted.configuration for found in answers])
    warn_of_misses(errors)
    for found in answers:
        for why in dict.fromkeys(found.unanswered.values()):
            asked = [name for name, reason in found.unanswered.items() if reason == why]
            warn(f"{found.wanted.configuration}, no answer to {', '.join(asked)}: {why}.")
    if as_json:
        print_json([as_dict(found, own) for found, own in zip(answers, errors, strict=True)])
    else:
        for found in answers:
            for table in tables(found):
                print_table(table.title, table.columns, table.rows)
        say_errors(errors)
    if output is not None:
        from labrig.report.design.figures import draw_design

        try:
            output.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise BadInputError(f"{output}: cannot be made ({error.strerror}).") from None
        for found in answers:
            for path in draw_design(known, found, output):
                if not as_json:
                    say(f"wrote {path}")


def _check(positive: dict[str, float | None], lag_s: float) -> None:
    for name, value in positive.items():
        if value is not None and not 0.0 < value < math.inf:
            raise BadInputError(f"{name} {value:g}: a number above 0 is needed.")
    if not 0.0 <= lag_s < math.inf:
        raise BadInputError(f"--lag-s {lag_s:g}: a number from 0 is needed.")


def _section(text: str) -> tuple[float, float]:
    parts = text.split(":")
    try:
        low_mm, high_mm = (float(part) for part in parts)
    except ValueError:
        raise BadInputError(
            f"--section {text!r}: two positions in mm with a colon between, such as 0:30."
        ) from None
    if not low_mm < high_mm:
        raise BadInputError(f"--section {text}: the first position must be below the second.")
    return low_mm / 1000, high_mm / 1000


COMMAND = Command(
    "design",
    design,
    order=200,
    examples=(CommandExample(line="labrig design model.toml --section 0:20"),),
)
