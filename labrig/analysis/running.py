"""Measurements of a session while it is recorded: each run is measured when it is over."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from labrig.analysis.analyze import AnalysisInputs, inputs_of
from labrig.analysis.conditions import conditions_of
from labrig.analysis.curves import ConditionCurves, curve_jobs, curves_of
from labrig.analysis.forces import ForceReading, measure_forces
from labrig.session import RecordedSession, RunRecord, open_session
from model.measurements import Measurements
from protocols.execution.events import Outcome

SETTLE_S = 1.0  # rows may follow the end of their run by two flushes of the file
Extent = tuple[int, ...]


@dataclass(frozen=True)
class _MeasuredRun:
    """One run, and how much of it was in the file when it was measured."""

    extent: Extent
    forces: tuple[ForceReading, ...]
    curves: tuple[ConditionCurves, ...]


class RunningAnalysis:
    """Reads the file only; between two calls it is closed.

    `pause` is called between images of different conditions and may block: what is measured
    waits for the run, never the other way round.
    """

    def __init__(
        self,
        path: Path,
        pause: Callable[[], None] = lambda: None,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self._path = path
        self._pause = pause
        self._now = now
        self._runs: dict[int, _MeasuredRun] = {}
        self._seen: dict[tuple[int, Extent], float] = {}  # since when a run has this extent

    def measure_next(self) -> Measurements | None:
        """Measure the next completed run and return the measurements of all runs measured so far.

        None: there is nothing new. A run that was marked since is measured again. Raises
        BadInputError where the session cannot be read.
        """
        with open_session(self._path, live=True) as session:
            grows = session.outcome is Outcome.RUNNING
            new = (run for run in session.runs if self._is_new(run, grows=grows))
            run = next(new, None)
            if run is None:
                return None
            given = inputs_of(session)
            self._runs[run.planned.index] = self._measured(session, run, given)
            return self._all(session, given)

    def _is_new(self, run: RunRecord, *, grows: bool) -> bool:
        """Whether a run is complete, was not measured as it is now, and will not change by itself.

        A run's end is in the file at once, its last rows a little later.
        """
        if not run.completed:
            return False
        extent, index = _extent(run), run.planned.index
        known = self._runs.get(index)
        if known is not None and known.extent == extent:
            return False
        since_s = self._seen.setdefault((index, extent), self._now())
        return not grows or self._now() - since_s >= SETTLE_S

    def _measured(
        self, session: RecordedSession, run: RunRecord, given: AnalysisInputs
    ) -> _MeasuredRun:
        curves: list[ConditionCurves] = []
        if given.optics is not None:
            for job in curve_jobs(session, given.optics, given.sheets, runs=[run]):
                self._pause()
                curves.append(curves_of(job, session))
        return _MeasuredRun(_extent(run), measure_forces(run, given.calibration), tuple(curves))

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
            camera=given.camera_uncertainty(curves),
        )


def _extent(run: RunRecord) -> Extent:
    return len(run.marks), len(run.readings_as_taken), run.samples, run.frame_count
