"""Whether a session knows when its sheet was moistened."""

from __future__ import annotations

from labrig.session import RecordedSession


def wetting_warnings(session: RecordedSession) -> list[str]:
    """Return a sentence where the sheet was to be moistened and nobody said that it was."""
    unknown = [
        run.planned.index + 1
        for run in session.runs
        if run.started and run.planned.moisten and run.since_wetting_s is None
    ]
    if not unknown:
        return []
    begun = sum(run.started and run.planned.moisten for run in session.runs)
    which = "" if len(unknown) == begun else f" before run {', '.join(map(str, unknown))}"
    text = (
        f"When the sheet was moistened{which} is not known, since nobody was asked (--yes): the "
        "time since wetting stays empty, and what dries or drifts counts from each run's beginning."
    )
    return [text]
