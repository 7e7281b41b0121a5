"""All that a report is made from, gathered once; what cannot be had is a sentence instead."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from labrig.errors import BadInputError, ReadOnlyError
from labrig.progress import Progress
from labrig.report.data.fitted import FittedSheets, fit_what_can_be
from labrig.report.data.kept_diagnosis import kept_diagnosis
from labrig.report.data.quality import Quality, quality
from labrig.report.data.selection import configurations
from labrig.report.data.suspicions import suspicions
from labrig.session import RecordedSession, load_measurements, open_session, stored_curve_extractor
from labrig.session.supplements.store import check_can_be_added_to
from model import Fit, FitOptions, Measurements, ModelError
from protocols.execution.events import Outcome

if TYPE_CHECKING:
    from model.discrepancy import Suspicion
    from model.discrepancy.verdict.result import Diagnosis
    from model.identification.baselines import BaselineRow

FEW_WARNINGS = 5  # of an analysis that are told at once; the report has all


@dataclass(frozen=True, kw_only=True)
class Findings:
    """A session, and what was found in it as far as that goes. The session is open."""

    session: RecordedSession
    measurements: Measurements | None
    fitted: FittedSheets
    why_not: str  # why there are no measurements
    diagnosis: Diagnosis | None = None  # where the session holds one

    @property
    def fit(self) -> Fit | None:
        """The fit of the configurations that allow one."""
        return self.fitted.fit

    @cached_property
    def names(self) -> list[str]:
        """The configurations that were measured."""
        return [] if self.measurements is None else configurations(self.measurements)

    @cached_property
    def baselines(self) -> tuple[BaselineRow, ...]:
        """Simpler models fitted to the same; empty where the data do not allow it."""
        if self.fit is None or self.measurements is None:
            return ()
        from model.identification.baselines import compare

        names = tuple(self.fit.configurations)
        try:
            options = replace(self.fit.options, configurations=names)
            return compare(self.measurements, options, self.fit)
        except ModelError:
            return ()

    @cached_property
    def suspicions(self) -> tuple[Suspicion, ...]:
        """What the data say against what is stated of them."""
        return () if self.measurements is None else suspicions(self.measurements)

    @cached_property
    def quality(self) -> Quality:
        """Of the raw data."""
        return quality(self.session, self.measurements)


def measured(
    path: Path,
    progress: Progress,
    tell: Callable[[str], None],
    *,
    processes: int = 1,
) -> Measurements:
    """Return a session's measurements, analysed now where that was not done or is out of date.

    `tell` reports it, what the analysis warns of, and that a session was not completed. Where the
    session cannot be changed the result is not kept in it.

    `processes`: how many search for curves at a time. More than one need a script that is
    importable, so what a script may call takes one, and the command line `workers`.
    """
    with open_session(path) as session:
        known, outdated = session.has_measurements, session.outdated
        for text in _cut_short(session):
            tell(f"{path}: {text}")
    if known and not outdated:
        return load_measurements(path)
    from labrig.analysis.analyze import analyze, measure
    from labrig.extractors.choice import BUILT_IN

    why = "runs or readings were marked since it was analysed" if outdated else "not analysed yet"
    chosen = stored_curve_extractor(path).partition(" ")[0] or BUILT_IN
    try:
        check_can_be_added_to(path)
    except ReadOnlyError as error:
        tell(f"{path}: {why}; analysing it now. The result is not kept: {error}")
        with open_session(path) as session:
            found = measure(session, progress, workers=processes, extractor=chosen)
    else:
        tell(f"{path}: {why}; analysing it now, and keeping the result in it.")
        found = analyze(path, progress, workers=processes, extractor=chosen)
    for text in found.warnings[:FEW_WARNINGS]:
        tell(f"{path}: {text}")
    if len(found.warnings) > FEW_WARNINGS:
        tell(f"{path}: `labrig report` shows all {len(found.warnings)} warnings of the analysis.")
    return found


def _cut_short(session: RecordedSession) -> Iterator[str]:
    """Yield why runs are missing, where a session was not completed."""
    if session.runs and session.outcome is not Outcome.COMPLETED:
        done = sum(run.started and run.completed for run in session.runs)
        yield (
            f"this session was not completed ({session.outcome.value}): {done} of its"
            f" {len(session.runs)} runs are complete"
        )


def workers() -> int:
    """Return how many processes may search for curves at a time."""
    return max(1, min(4, os.cpu_count() or 1))


def gather(
    path: Path,
    progress: Progress,
    tell: Callable[[str], None],
    options: FitOptions | None = None,
    *,
    processes: int = 1,
) -> Findings:
    """Measure and fit a session as far as that goes. Raises BadInputError when it is no session."""
    open_session(path).close()
    measurements, why = None, ""
    try:
        measurements = measured(path, progress, tell, processes=processes)
    except BadInputError as error:
        why = str(error)
    fitted = FittedSheets(None)
    if measurements is not None:
        fitted = fit_what_can_be(measurements, options)
    diagnosis = None
    try:
        diagnosis = kept_diagnosis(path)
    except BadInputError as error:
        tell(str(error))
    return Findings(
        session=open_session(path),
        measurements=measurements,
        fitted=fitted,
        why_not=why,
        diagnosis=diagnosis,
    )
