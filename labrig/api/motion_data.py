"""What `fit_in_time` and `next_in_time` have in common: the motion recorded in sessions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from labrig.analysis.analyze import inputs_of, shunt_ohm
from labrig.analysis.motion.beginning import ELONGATION_UNKNOWN, StatedValues
from labrig.analysis.motion.dynamic_fit import DynamicFit, NoSheetInTimeError, dynamic_fit
from labrig.analysis.motion.record import MotionRecord, motion_record, moving_configurations
from labrig.api.arguments import elongation_kg_per_m, numbers, one_of, several
from labrig.api.data import paths_of, tell
from labrig.errors import BadArgumentError, BadInputError
from labrig.files import AnyPath
from labrig.progress import Progress, within
from labrig.session import RecordedSession, open_session

READING_SHARE: Final = 0.4  # of the time of a fit, most of it for the images
MOST_POSITIONS: Final = 3  # in contact, unless they are named: each adds seconds
FLUIDS: Final = ("air", "water", "vacuum")


@dataclass(frozen=True, kw_only=True)
class MotionRequest:
    """What the user states of the sheet in time."""

    sessions: tuple[Path, ...]
    configurations: tuple[str, ...] = ()  # none: all that moved
    positions_mm: tuple[float, ...] = ()  # none: `MOST_POSITIONS` of those measured
    fluid: str = "air"
    elongation_kg_per_m: float | None = None


def request_of(
    sessions: AnyPath | Sequence[AnyPath],
    configuration: str | Sequence[str],
    position_mm: float | Sequence[float],
    fluid: str,
    elongation_g_per_m: float | None,
) -> MotionRequest:
    """Return what is asked for. Raises BadInputError of one sentence."""
    paths = paths_of(sessions)
    if not paths:
        raise BadInputError("give at least one session.")
    elongation = elongation_kg_per_m(elongation_g_per_m)
    one_of("fluid", fluid, FLUIDS)
    return MotionRequest(
        sessions=tuple(paths), configurations=tuple(several(configuration)),
        positions_mm=tuple(numbers("position_mm", position_mm)), fluid=fluid,
        elongation_kg_per_m=elongation,
    )  # fmt: skip


def fits_of(request: MotionRequest, progress: Progress | None) -> list[DynamicFit]:
    """Read the sessions and fit each configuration that moved in them.

    One whose elongation's mass is not stated, or that moves like no sheet of the model, is left
    out, in words; it is refused where it was asked for or is the only one.
    """
    with open_session(request.sessions[0]) as session:
        found = _determinable(request, session)
        source_ohm = shunt_ohm(session) or 1.0
    stated = StatedValues(
        fluid=request.fluid, source_ohm=source_ohm,
        elongation_kg_per_m=request.elongation_kg_per_m,
    )  # fmt: skip
    fits, left_out = list[DynamicFit](), list[str]()
    names: Sequence[str | None] = found or (None,)
    for i, name in enumerate(names):
        own = within(progress, i / len(names), (i + 1) / len(names))
        records = records_of(request, name, within(own, 0.0, READING_SHARE))
        for text in dict.fromkeys(text for one in records for text in one.missing):
            tell(f"{name}: {text}" if len(names) > 1 else text)
        fitting = within(own, READING_SHARE, 1.0)
        try:
            fits.append(dynamic_fit(records, stated, progress=fitting))
        except NoSheetInTimeError as error:
            left_out.append(str(error))
    if left_out and (request.configurations or not fits):
        raise BadInputError(left_out[0])
    for text in left_out:
        tell(f"left out: {text}")
    return fits


def _determinable(request: MotionRequest, session: RecordedSession) -> tuple[str, ...]:
    """Return the configurations to fit; told before minutes are spent on reading images."""
    moved = tuple(moving_configurations(session))
    found = request.configurations or moved
    if request.elongation_kg_per_m is not None or not moved:
        return found
    sheets = inputs_of(session).sheets
    unknown = [name for name in found if name in moved and sheets[name].elongation_m > 0.0]
    rest = tuple(name for name in found if name not in unknown)
    if unknown and (request.configurations or not rest):
        raise BadArgumentError(ELONGATION_UNKNOWN.format(unknown[0]), "elongation_g_per_m")
    for name in unknown:
        tell(f"'{name}' is left out: {ELONGATION_UNKNOWN.format(name)}", "elongation_g_per_m")
    return rest


def records_of(
    request: MotionRequest, name: str | None, progress: Progress | None
) -> list[MotionRecord]:
    """Read one configuration of all sessions."""
    found, count = [], len(request.sessions)
    for i, path in enumerate(request.sessions):
        with open_session(path) as session:
            found.append(
                motion_record(
                    session, name, positions_m=_positions_m(request, session, name),
                    progress=within(progress, i / count, (i + 1) / count),
                )
            )  # fmt: skip
    return found


def _positions_m(request: MotionRequest, session: RecordedSession, name: str | None) -> list[float]:
    """Return the positions that are fitted: those asked for, or some of all."""
    there = _measured_positions_m(session, name)
    for wanted_mm in request.positions_mm:
        if not any(abs(1e-3 * wanted_mm - at_m) < 1e-6 for at_m in there):
            known = ", ".join(f"{1e3 * at_m:g}" for at_m in there) or "none"
            raise BadArgumentError(
                f"position_mm {wanted_mm:g}: {session.path} was measured at {known} mm.",
                "position_mm",
            )
    if request.positions_mm:
        return [1e-3 * wanted_mm for wanted_mm in request.positions_mm]
    chosen = spread(there, MOST_POSITIONS)
    if len(chosen) < len(there):
        at = ", ".join(f"{1e3 * at_m:g}" for at_m in chosen)
        tell(
            f"of {len(there)} positions those at {at} mm are used; more with position_mm.",
            "position_mm",
        )
    return chosen


def _measured_positions_m(session: RecordedSession, name: str | None) -> list[float]:
    return sorted({
        run.planned.position_m
        for run in session.runs
        if run.planned.measures and run.completed and run.planned.position_m is not None
        and name in (None, run.planned.configuration)
    })  # fmt: skip


def spread(values: Sequence[float], most: int) -> list[float]:
    """Return at most so many of sorted values, the first, the last and some evenly between."""
    if len(values) <= most:
        return list(values)
    return [values[round(k * (len(values) - 1) / (most - 1))] for k in range(most)]


def checksum_of(request: MotionRequest) -> str:
    """Return the checksum of the first session's data, for the model file."""
    with open_session(request.sessions[0]) as session:
        checksum: Any = session.data_checksum
    return str(checksum)
