"""Marks of a session as a table: what was declared invalid, or taken back, by whom and why."""

from __future__ import annotations

from collections.abc import Sequence

from labrig.report.parts.table import Table
from labrig.session import Mark, RecordedSession

DURING = "during the session"


def all_marks(session: RecordedSession) -> list[Mark]:
    """Return the marks made during the session, then those made after its end, oldest first."""
    during = [mark for run in session.runs for mark in run.marks_during]
    return [*during, *session.marks_after_end]


def marks_as_table(marks: Sequence[Mark], title: str = "Marks") -> Table:
    """Return a row for each mark; runs and readings count from 1."""
    rows = tuple(
        (
            str(mark.run + 1),
            "whole run" if mark.reading is None else str(mark.reading + 1),
            "invalid" if mark.invalid else "mark taken back",
            mark.why,
            mark.who,
            mark.when[:16].replace("T", " ") if mark.when else DURING,
        )
        for mark in marks
    )
    columns = ("run", "reading", "mark", "why", "by", "when (UTC)")
    return Table(title=title, columns=columns, rows=rows, text=True)
