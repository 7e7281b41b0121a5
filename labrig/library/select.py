"""Which sessions, in which order."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable
from typing import Any

from labrig.errors import BadInputError
from labrig.library.entry import CatalogueEntry

_FITTED = ("B_Nm2", "E_Pa", "EIBM_Nm", "rmse_force_mN", "rmse_curve_mm")
_PLAIN = (
    "name",
    "started",
    "sheet",
    "protocol",
    "title",
    "project",
    "sample",
    "outcome",
    "runs",
    "runs_complete",
    "readings",
    "invalid",
    "bytes",
    "duration_s",
    "largest_force_mN",
    "scatter_mN",
)
COLUMNS = (*_PLAIN, *_FITTED)


def select(
    entries: Iterable[CatalogueEntry],
    *,
    sort: str = "started",
    down: bool = True,
    text: str = "",
    outcome: str = "",
    sheet: str = "",
) -> list[CatalogueEntry]:
    """Those that fit, sorted by a column; what a session does not have comes last either way.

    `text` is looked for in name, protocol, sheet, reason and fault, in what is stated of people and
    sample, and in the notes, without regard to capitals.
    """
    check_column(sort)
    wanted = text.lower().split()
    found = [
        entry
        for entry in entries
        if (not outcome or entry.outcome == outcome)
        and (not sheet or sheet in entry.sheet)
        and all(word in _words(entry) for word in wanted)
    ]
    value = _value_of(sort)
    known = [entry for entry in found if value(entry) not in (None, "", ())]
    known.sort(key=lambda entry: (value(entry), entry.name), reverse=down)
    rest = [entry for entry in found if value(entry) in (None, "", ())]
    return [*known, *sorted(rest, key=lambda entry: entry.name)]


def check_column(name: str) -> None:
    """Raise BadInputError where sessions cannot be sorted by that."""
    if name not in COLUMNS:
        close = difflib.get_close_matches(name, COLUMNS, n=1)
        hint = f"did you mean {close[0]}" if close else "started, name and B_Nm2 are some"
        raise BadInputError(f"--sort {name}: there is no such column; {hint}.")


def _value_of(column: str) -> Callable[[CatalogueEntry], Any]:
    if column in _FITTED:
        return lambda entry: entry.fitted(column)
    return lambda entry: getattr(entry, column)


def _words(entry: CatalogueEntry) -> str:
    parts = (entry.name, entry.protocol, *entry.sheet, entry.reason, entry.error or "", entry.words)
    return " ".join(parts).lower()
