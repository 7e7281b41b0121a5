"""From which amplitude on effects would be seen in the data."""

from __future__ import annotations

from labrig.report.parts.table import Table, number
from model.discrepancy.verdict.result import Diagnosis
from model.effects import title


def limits_table(found: Diagnosis) -> Table | None:
    """Return detection limits beside what is named, of effects that are not; the tightest first."""
    some = [item for item in found.limits.items() if item[0] not in found.invisible]
    if not some:
        return None
    some.sort(key=lambda item: item[1].ratio)
    rows = tuple(
        (
            title(name),
            one.parameter,
            number(one.value),
            one.unit or "-",
            number(one.ratio),
        )
        for name, one in some
    )
    return Table(
        title="Detection limits",
        columns=("effect", "parameter", "seen from", "unit", "over its usual size"),
        rows=rows,
        note="Less than that (4 standard deviations, beside what is named) is not ruled out.",
    )
