"""Measurements of a session while it is recorded: each run is measured when it is over."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from labrig.analysis.analyze import AnalysisInputs, inputs_of
from labrig.analysis.conditions import conditions_of
from labrig.analysis.curves import ConditionCurves, curve_jobs, curves_of
from labrig.analysis.forces import ForceReading, measure_forces
from labrig.session import RecordedSession, RunRecord, open_session
from model.measurements import Measurements


@dataclass(frozen=True)
class _MeasuredRun:
    """One run, and how many marks it had when it was measured."""

    marks: int
    forces: tuple[ForceReading, ...]
    curves: tuple[ConditionCurves, ...]


class RunningAnalysis:
    """Reads the file only; between two calls it is closed.

    `pause` is called between images of different conditions and may block: what is measured
    waits for the run, never the other way round.
    """

    def __init__(self, path: Path, pause: Callable[[], None] = lambda: None) -> None:
        self._path = path
        self._pause = pause
        self._runs: dict[int, _MeasuredRun] = {}

    def measure_next(self) -> Measurements | None:
        """Measure the next completed run and return the measurements of all runs measured so far.

        None: there is nothing new. A run that was marked since is measured again. Raises
        BadInputError where the session cannot be read.
        """
        with open_session(self._path, live=True) as session:
            run = next(filter(self._is_new, session.runs), None)
            if run is None:
                return None
            given = inputs_of(session)
            self._runs[run.planned.index] = self._measured(session, run, given)
            return self._all(session, given)

    def _is_new(self, run: RunRecord) -> bool:
        if not run.completed:
            return False
        known = self._runs.get(run.planned.index)
        return known is None or known.marks != len(run.marks)

    def _measured(
        self, session: RecordedSession, run: RunRecord, given: AnalysisInputs
    ) -> _MeasuredRun:
        curves: list[ConditionCurves] = []
        if given.optics is not None:
            for job in curve_jobs(session, given.optics, given.sheets, runs=[run]):
                self._pause()
                curves.append(curves_of(job, session))
        return _MeasuredRun(len(run.marks), measure_forces(run, given.calibration), tuple(curves))

    def _all(self, session: RecordedSession, given: AnalysisInputs) -> Measurements:
        """Return what the analysis of these runs alone returns, without time series."""
        runs = [self._runs[index] for index in sorted(self._runs)]
        forces = {index: run.forces for index, run in self._runs.items()}
        curves = [one for run in runs for one in run.curves]
        return Measurements(
            sheets=given.sheets,
            conditions=conditions_of(session, forces, curves),
            series=(),
            source=session.path.name,
            warnings=tuple(text for one in curves for text in one.warnings),
        )
