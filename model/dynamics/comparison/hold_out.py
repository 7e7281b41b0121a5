"""Which runs and pulses a model is fitted to, and which it has to predict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.dynamics.comparison.compared_run import ComparedRun
from model.measurements import FloatArray

LEAST_POSITIONS = 3  # of which one is left out
EVERY = 3  # position, and pulse of a run, is left out
LEAST_PULSES = 2


@dataclass(frozen=True)
class HeldOut:
    """Runs to fit and runs to predict; what is fitted of a run keeps the drive of all of it."""

    fitted: tuple[ComparedRun, ...]
    predicted: tuple[ComparedRun, ...]

    @property
    def in_words(self) -> str:
        """Return what is predicted."""
        fitted = {run.position_m for run in self.fitted}
        places = sorted({
            run.position_m for run in self.predicted
            if run.position_m is not None and run.position_m not in fitted
        })  # fmt: skip
        parts = [f"all at {', '.join(f'{1e3 * p:g}' for p in places)} mm"] if places else []
        if any(run.position_m in fitted for run in self.predicted):
            parts.append("the last third of the pulses of each other run")
        return " and ".join(parts) or "nothing"


def hold_out(runs: Sequence[ComparedRun]) -> HeldOut:
    """Return every third position (the middle one of three) and the last pulses as predicted.

    A pulse begins with a change of the voltage; where a run has but one, as a release has, its last
    third of time is predicted.
    """
    places = sorted({run.position_m for run in runs if run.position_m is not None})
    out = {*places[EVERY // 2 :: EVERY]} if len(places) >= LEAST_POSITIONS else set()
    fitted: list[ComparedRun] = []
    predicted: list[ComparedRun] = []
    for run in runs:
        if run.position_m in out:
            predicted.append(run)
            continue
        cut = _cut_s(run)
        for into, part in ((fitted, run.part(-np.inf, cut)), (predicted, run.part(cut, np.inf))):
            if part is not None:
                into.append(part)
    return HeldOut(tuple(fitted), tuple(predicted))


def _cut_s(run: ComparedRun) -> float:
    """Return the time from which on a run is predicted."""
    times = np.concatenate([run.plan.time_s, run.plan.frame_s])
    first, last = float(np.min(times)), float(np.max(times))
    drive: FloatArray = run.plan.drive.time_s
    jumps = np.diff(run.plan.drive.voltage_V, prepend=0.0) != 0.0
    edges = drive[jumps & (drive > first) & (drive < last)]
    if len(edges) > LEAST_PULSES:
        return float(edges[-max(1, len(edges) // EVERY)])
    return last - (last - first) / EVERY
