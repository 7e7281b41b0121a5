"""What the verdict checks said of the named effects, as a table."""

from __future__ import annotations

from labrig.report.parts.table import Table
from model.discrepancy import CheckResult, Diagnosis
from model.effects import title


def check_table(found: Diagnosis) -> Table | None:
    """Return every check with its outcome, failed ones first; None where nothing was named."""
    if not found.checks:
        return None
    rows = tuple(_row(one) for one in sorted(found.checks, key=lambda one: one.passed))
    which = "named" if found.effects else "considered"
    failed = sum(not one.passed for one in found.checks)
    return Table(
        title=f"Checks of the {which} effects", columns=("check", "outcome", "effect", "finding"),
        rows=rows, note=f"{failed} of {len(rows)} checks failed.", text=True,
    )  # fmt: skip


def _row(one: CheckResult) -> tuple[str, ...]:
    names = ", ".join(title(name) for name in one.effects)
    outcome = "passed" if one.passed else "failed"
    return one.name.replace("_", " "), outcome, names or "-", one.sentence
