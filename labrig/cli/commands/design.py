"""What a sheet can do, and which sheet one needs: design."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.model_errors import say_errors
from labrig.cli.options import EachConfiguration, Json, ModelFile, OwnEibm, StatedStiffness
from labrig.cli.screen import print_json, print_table, say, warn
from labrig.cli.stated_model import StatedModel
from labrig.errors import BadInputError

if TYPE_CHECKING:
    from labrig.api.design import Design
    from model import SheetModel
    from model.design.elongation_map import ElongationMap


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
    bandwidth_hz: Annotated[
        float, typer.Option("--bandwidth-hz", help="wanted of the controlled object")
    ] = 1.0,
    lag_s: Annotated[float, typer.Option("--lag-s", help="of the voltage's effect")] = 0.0,
    eibm: OwnEibm = None,
    stiffness_Nm2: StatedStiffness = None,
    with_map: Annotated[
        bool, typer.Option("--map", help="also the map of sections for which an elongation pays")
    ] = False,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="a folder for the figures")
    ] = None,
    as_json: Json = False,
) -> None:
    """Answer the paper's design questions for a section.

    The working section of the arc is that of the paper's section 5.

    Best line and controller, largest difference of shapes, shortest sheet, largest forces, force in
    both directions, the sheet of least area with and without a rigid elongation, and the work along
    the arc. Each question is answered by itself; where one has no answer, the reason is printed. A
    model that does not describe its own data gives a warning.

    With --eibm, for EIBMs of your own; with --stiffness-Nm2 too, sheet.toml takes the model file's
    place.
    """
    from labrig.api.design import check_requirements, map_of_elongation, section_m
    from labrig.api.design import design as design_for

    section_m(section)
    check_requirements(force_mN=force_mN, mass_g=mass_g, bandwidth_hz=bandwidth_hz, lag_s=lag_s)
    if output is not None and output.exists() and not output.is_dir():
        raise BadInputError(f"{output}: this is a file, a folder is needed.")
    known = StatedModel(model, eibm or (), stiffness_Nm2).model()
    answers = design_for(
        known, section, configuration=configuration or (), force_mN=force_mN,
        direction=direction.value, mass_g=mass_g, bandwidth_hz=bandwidth_hz, lag_s=lag_s,
    )  # fmt: skip
    for found in answers:
        for why in dict.fromkeys(found.unanswered.values()):
            asked = [name for name, reason in found.unanswered.items() if reason == why]
            warn(f"{found.wanted.configuration}, no answer to {', '.join(asked)}: {why}.")
    maps = {
        found.wanted.configuration: map_of_elongation(
            known, section, configuration=found.wanted.configuration, direction=direction.value
        )
        for found in answers
        if with_map
    }
    _show(answers, maps, known, as_json=as_json)
    for path in [] if output is None else _draw(known, answers, maps, output):
        if not as_json:
            say(f"wrote {path}")


def _show(
    answers: Design, maps: dict[str, ElongationMap], known: SheetModel, *, as_json: bool
) -> None:
    from labrig.report.design.answers import tables
    from labrig.report.design.elongation import as_dict, elongation_table

    if as_json:
        plain = {name: {"elongation_map": as_dict(one)} for name, one in maps.items()}
        print_json([{**one, **plain.get(one["configuration"], {})} for one in answers.to_json()])
        return
    every = [table for found in answers for table in tables(found)]
    for table in (*every, *(elongation_table(name, one) for name, one in maps.items())):
        print_table(table.title, table.columns, table.rows)
        if table.note:
            say(table.note)
            say()
    say_errors(answers.errors, known)


def _draw(
    model: SheetModel, answers: Design, maps: dict[str, ElongationMap], folder: Path
) -> list[Path]:
    """Draw all figures into a folder and return their paths."""
    from labrig.report.design.elongation import draw_elongation_map
    from labrig.report.design.figures import draw_design

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInputError(f"{folder}: cannot be made ({error.strerror}).") from None
    written = [path for found in answers for path in draw_design(model, found, folder)]
    for name, one in maps.items():
        written.append(folder / f"{name}-elongation-map.png")
        draw_elongation_map(name, one, written[-1])
    return written


COMMAND = Command(
    "design",
    design,
    order=200,
    examples=(CommandExample(line="labrig design model.toml --section 0:20"),),
)
