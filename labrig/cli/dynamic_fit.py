"""What `labrig fit --dynamic` and `labrig next --dynamic` have in common with the command line."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from labrig.cli.screen import print_json, print_table, progress, say
from labrig.errors import BadInputError


class SheetFluid(StrEnum):
    """What the sheet moves in."""

    AIR = "air"
    WATER = "water"
    VACUUM = "vacuum"


DynamicPositions = Annotated[
    list[float] | None,
    typer.Option(
        "--position-mm",
        help="with --dynamic: a position that is used, repeatable; by default 3",
    ),
]
DynamicFluid = Annotated[
    SheetFluid, typer.Option("--fluid", help="with --dynamic: what the sheet moves in")
]
ElongationMass = Annotated[
    float | None,
    typer.Option(
        "--elongation-g-per-m", help="with --dynamic: mass of the rigid elongation per length"
    ),
]


@dataclass(frozen=True, kw_only=True)
class DynamicRequest:
    """What the user states."""

    sessions: list[Path]
    configurations: list[str]
    positions_mm: list[float]
    fluid: str = "air"
    elongation_g_per_m: float | None = None


def refuse_others(command: str, given: dict[str, Any]) -> None:
    """Raise BadInputError where options were given that do not go with --dynamic."""
    other = next((name for name, value in given.items() if value not in (None, False, [], 0)), None)
    if other is not None:
        raise BadInputError(f"labrig {command} --dynamic does not go with {other}; leave one out.")


def refuse_without_dynamic(request: DynamicRequest) -> None:
    """Raise BadInputError where what only the sheet in time needs was given without --dynamic."""
    given = {
        "--position-mm": request.positions_mm, "--fluid": request.fluid != SheetFluid.AIR,
        "--elongation-g-per-m": request.elongation_g_per_m is not None,
    }  # fmt: skip
    for name, value in given.items():
        if value:
            raise BadInputError(f"{name} is for the sheet in time: give --dynamic with it.")


def print_fit_in_time(request: DynamicRequest, output: Path | None, *, as_json: bool) -> None:
    """Identify the sheets in time, print them and write the model file."""
    from labrig.api.fit_in_time import fit_in_time
    from labrig.model_file import save_model
    from labrig.report.tables.in_time.parameters import dynamic_table, noise_sentence

    with progress("fit in time") as advance:
        found = fit_in_time(
            request.sessions, configuration=request.configurations,
            position_mm=request.positions_mm, fluid=request.fluid,
            elongation_g_per_m=request.elongation_g_per_m, progress=advance,
        )  # fmt: skip
    if output is not None:
        save_model(found.model, output, force=True)
    if as_json:
        print_json(found.to_json())
        return
    for fit in found.configurations.values():
        table = dynamic_table(fit)
        print_table(table.title, table.columns, table.rows)
        say(table.note)
        say(noise_sentence(fit))
        say()
    if output is not None:
        say(f"wrote {output}")


def print_next_in_time(request: DynamicRequest, model: Path | None, *, as_json: bool) -> None:
    """Print what further runs would determine of each configuration."""
    from labrig.api.next_in_time import next_in_time
    from labrig.report.tables.in_time.proposals import next_table, next_text

    with progress("fit in time") as advance:
        found = next_in_time(
            request.sessions, model=model, fluid=request.fluid,
            elongation_g_per_m=request.elongation_g_per_m, progress=advance,
        )  # fmt: skip
    if as_json:
        print_json(found.to_json())
        return
    for name, offered in found.configurations.items():
        table = next_table(name, offered)
        print_table(table.title, table.columns, table.rows)
        say(table.note)
        for text in next_text(offered):
            say(text)
        say()
