"""The measurements that a command's arguments name, read with a progress bar."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from labrig.cli.screen import progress, warn
from labrig.errors import BadInputError

if TYPE_CHECKING:
    from model import Measurements
    from model.discrepancy import Suspicion


def of_sessions(sessions: Sequence[Path]) -> Measurements:
    """Return the measurements of sessions, combined; analyse what is not analysed yet."""
    from labrig.api.data import measurements_of
    from labrig.report.data.findings import workers

    with progress("analyze") as advance:
        return measurements_of(sessions, advance, processes=workers())


def of_sessions_or_tables(
    sessions: list[Path] | None,
    sheet: Path | None,
    forces: Path | None,
    curves: Path | None,
    signals: Path | None,
    *,
    columns: list[str] | None = None,
    values: list[str] | None = None,
    ignore: list[str] | None = None,
) -> Measurements:
    """Return the measurements of sessions, or of tables with a sheet.toml.

    Says how a table was understood that is not written as labrig writes it.
    """
    from labrig.api.tables import GivenTables, data_of

    tables = GivenTables(
        sheet=sheet, forces=forces, curves=curves, signals=signals,
        columns=columns or (), values=values or (), ignore=ignore or (),
    )  # fmt: skip
    if sessions and not tables:
        return of_sessions(sessions)
    return data_of(sessions, tables, None)


def check_stiffness(stated_Nm2: float | None) -> None:
    """Raise BadInputError for a stiffness that no sheet has."""
    if stated_Nm2 is not None and not 0.0 < stated_Nm2 < math.inf:
        raise BadInputError(f"--stiffness-Nm2 {stated_Nm2:g}: a number above 0 is needed.")


def warn_of_suspicions(measurements: Measurements) -> tuple[Suspicion, ...]:
    """Warn of what is suspicious about measurements as they are stated, and return it."""
    from labrig.report.data.suspicions import suspicions

    found = suspicions(measurements)
    for one in found:
        warn(f"check the data: {one.sentence}.")
    return found
