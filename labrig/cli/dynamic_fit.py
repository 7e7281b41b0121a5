"""What `labrig fit --dynamic` and `labrig next --dynamic` have in common with the command line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from labrig.cli.screen import print_json, print_table, progress, say, warn
from labrig.errors import BadInputError

if TYPE_CHECKING:
    from labrig.analysis.motion.dynamic_fit import DynamicFit
    from labrig.analysis.motion.record import MotionRecord

POOR_CURVE_M = 1e-4  # the curves of pictures are ten times better
MOST_POSITIONS = 3  # in contact, unless they are named: each adds seconds
GRAM = 1e-3


class SheetFluid(StrEnum):
    """What the sheet moves in."""

    AIR = "air"
    WATER = "water"
    VACUUM = "vacuum"


DynamicPositions = Annotated[
    list[float] | None,
    typer.Option(
        "--position-mm",
        help=f"with --dynamic: a position that is used, repeatable; by default {MOST_POSITIONS}",
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


def _check(request: DynamicRequest) -> None:
    if not request.sessions:
        raise BadInputError("--dynamic: give a session.")
    end = request.elongation_g_per_m
    if end is not None and not 0.0 < end < math.inf:
        raise BadInputError(f"--elongation-g-per-m {end:g}: a positive number is needed.")


def fit_in_time(request: DynamicRequest, output: Path | None, *, as_json: bool) -> None:
    """Identify the sheets in time, print them and write the model file."""
    from labrig.analysis.motion.dynamic_fit import model_of
    from labrig.model_file import save_model
    from labrig.report.tables.in_time.parameters import dynamic_json, dynamic_table, noise_sentence

    fits = fitted_in_time(request)
    if output is not None:
        save_model(model_of(fits, _checksum(request.sessions)), output)
    if as_json:
        print_json(dynamic_json(fits))
        return
    for fit in fits:
        table = dynamic_table(fit)
        print_table(table.title, table.columns, table.rows)
        say(table.note)
        say(noise_sentence(fit))
        if not fit.found.converged:
            warn(f"{fit.sheet.configuration}: the search did not end; take its intervals as rough.")
        if fit.noise.curve_m > POOR_CURVE_M:
            warn(
                f"{fit.sheet.configuration}: the curves are {1e3 * fit.noise.curve_m:.2f} mm off"
                " the fitted sheet, more than pictures explain; do not trust its mass and loss."
            )
        say()
    if output is not None:
        say(f"wrote {output}")


def fitted_in_time(request: DynamicRequest) -> list[DynamicFit]:
    """Read the sessions and fit each configuration that moved in them."""
    _check(request)
    from labrig.analysis.motion.beginning import StatedValues
    from labrig.analysis.motion.dynamic_fit import dynamic_fit
    from labrig.analysis.motion.record import moving_configurations
    from labrig.session import open_session

    fits = []
    with open_session(request.sessions[0]) as session:
        found = request.configurations or moving_configurations(session)
        source_ohm = _source_ohm(session)
    end = request.elongation_g_per_m
    stated = StatedValues(
        fluid=request.fluid, source_ohm=source_ohm,
        elongation_kg_per_m=None if end is None else GRAM * end,
    )  # fmt: skip
    names: list[str | None] = [*found] or [None]
    for name in names:
        records = records_of(request, name)
        for text in dict.fromkeys(text for one in records for text in one.missing):
            warn(text)
        fits.append(dynamic_fit(records, stated))
    return fits


def records_of(request: DynamicRequest, name: str | None) -> list[MotionRecord]:
    """Read one configuration of all sessions."""
    from labrig.analysis.motion.record import motion_record
    from labrig.session import open_session

    found = []
    with progress("read the motion") as advance:
        for path in request.sessions:
            with open_session(path) as session:
                positions_m = _positions_m(request, session, name)
                found.append(
                    motion_record(session, name, positions_m=positions_m, progress=advance)
                )
    return found


def _positions_m(request: DynamicRequest, session: Any, name: str | None) -> list[float]:
    """Return the positions that are fitted: those asked for, or some of all."""
    there = sorted({
        run.planned.position_m
        for run in session.runs
        if run.planned.measures and run.completed and run.planned.position_m is not None
        and name in (None, run.planned.configuration)
    })  # fmt: skip
    for wanted_mm in request.positions_mm:
        if not any(abs(1e-3 * wanted_mm - at_m) < 1e-6 for at_m in there):
            known = ", ".join(f"{1e3 * at_m:g}" for at_m in there) or "none"
            raise BadInputError(
                f"--position-mm {wanted_mm:g}: {session.path} was measured at {known} mm."
            )
    if request.positions_mm:
        return [1e-3 * wanted_mm for wanted_mm in request.positions_mm]
    chosen = spread(there, MOST_POSITIONS)
    if len(chosen) < len(there):
        at = ", ".join(f"{1e3 * at_m:g}" for at_m in chosen)
        warn(f"of {len(there)} positions those at {at} mm are used; more with --position-mm.")
    return chosen


def spread(values: Sequence[float], most: int) -> list[float]:
    """Return at most so many of sorted values, the first, the last and some evenly between."""
    if len(values) <= most:
        return list(values)
    return [values[round(k * (len(values) - 1) / (most - 1))] for k in range(most)]


def _source_ohm(session: Any) -> float:
    from labrig.analysis.analyze import shunt_ohm

    return shunt_ohm(session) or 1.0


def _checksum(sessions: list[Path]) -> str:
    from labrig.session import open_session

    with open_session(sessions[0]) as session:
        return str(session.data_checksum)
