"""The measurements that a command's arguments name, read with a progress bar."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from labrig.cli.screen import progress, warn

if TYPE_CHECKING:
    from model import Measurements
    from model.discrepancy import Suspicion


def of_sessions(sessions: Sequence[Path]) -> Measurements:
    """Return the measurements of sessions, combined; analyse what is not analysed yet."""
    from labrig.api.data import measurements_of

    with progress("analyze") as advance:
        return measurements_of(sessions, advance)


def of_sessions_or_tables(
    sessions: list[Path] | None,
    sheet: Path | None,
    forces: Path | None,
    curves: Path | None,
    signals: Path | None,
) -> Measurements:
    """Return the measurements of sessions, or of CSV tables with a sheet.toml."""
    from labrig.api.diagnose import data_of

    with progress("analyze") as advance:
        return data_of(sessions or None, (sheet, forces, curves, signals), advance)


def warn_of_suspicions(measurements: Measurements) -> tuple[Suspicion, ...]:
    """Warn of what is suspicious about measurements as they are stated, and return it."""
    from labrig.report.data.suspicions import suspicions

    found = suspicions(measurements)
    for one in found:
        warn(f"check the data: {one.sentence}.")
    return found
