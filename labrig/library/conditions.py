"""Mean and scatter of the recorded forces at each condition, as they were seen while running."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from labrig.session import RecordedSession, load_measurements
from model import Condition
from protocols.planning.schedule import ReadingKind

Key = tuple[str, float | None, float]  # configuration, position in mm, voltage
_COUNT = (ReadingKind.ZERO.value, ReadingKind.KEPT.value)


@dataclass(frozen=True)
class ConditionMean:
    """Of the valid readings that count; `scatter_mN` is None for a single one."""

    force_mN: float
    scatter_mN: float | None
    readings: int

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "force_mN": self.force_mN,
            "scatter_mN": self.scatter_mN,
            "readings": self.readings,
        }


def condition_means(session: RecordedSession) -> dict[Key, ConditionMean]:
    """By configuration, position and voltage, all runs there together."""
    forces: dict[Key, list[float]] = {}
    for condition in imported_conditions(session):
        if condition.position_m is not None:
            place_mm = round(1e3 * condition.position_m, 6)
            key = (condition.configuration, place_mm, round(condition.voltage_V, 9))
            used = [1e3 * reading.force_N for reading in condition.used()]
            forces.setdefault(key, []).extend(used)
    for run in session.runs:
        place_m = run.planned.position_m
        if not run.started or place_m is None:
            continue
        for row in run.readings:
            if row["valid"] and str(row["kind"]) in _COUNT:
                voltage_V = round(float(row["voltage_V"]), 9)
                key = (run.planned.configuration, round(1e3 * place_m, 6), voltage_V)
                forces.setdefault(key, []).append(1e3 * float(row["force_N"]))
    return {key: _mean(values) for key, values in forces.items() if values}


def imported_conditions(session: RecordedSession) -> tuple[Condition, ...]:
    """Return those of a session of imported tables, which has no runs; none of others."""
    if not session.imported:
        return ()
    return load_measurements(session.path).conditions


def compare_means(a: RecordedSession, b: RecordedSession) -> list[dict[str, Any]]:
    """Both sessions' conditions side by side; None where one of them has nothing."""
    left, right = condition_means(a), condition_means(b)
    keys = sorted(left.keys() | right.keys(), key=lambda key: (key[0], key[1] or 0.0, key[2]))
    return [
        {
            "configuration": key[0],
            "position_mm": key[1],
            "voltage_V": key[2],
            "a": left[key].as_dict() if key in left else None,
            "b": right[key].as_dict() if key in right else None,
        }
        for key in keys
    ]


def largest_force_mN(means: dict[Key, ConditionMean]) -> float | None:
    """Return the largest change of force that a voltage made, either sign."""
    found = [
        abs(mean.force_mN - zero.force_mN)
        for (name, place, voltage_V), mean in means.items()
        if voltage_V and (zero := means.get((name, place, 0.0))) is not None
    ]
    return max(found, default=None)


def median_scatter_mN(means: dict[Key, ConditionMean]) -> float | None:
    """Return the median of all conditions' scatter."""
    found = [mean.scatter_mN for mean in means.values() if mean.scatter_mN is not None]
    return float(np.median(found)) if found else None


def _mean(values: list[float]) -> ConditionMean:
    scatter = float(np.std(values, ddof=1)) if len(values) > 1 else None
    return ConditionMean(float(np.mean(values)), scatter, len(values))
