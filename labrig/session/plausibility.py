"""What in tables looks like another unit than the columns name: told, not refused."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np

from model.measurements import Condition, Curve, Measurements

# Far beyond what a sheet on such a rig does, and far below what its load cell and stage resolve.
_MOST_FORCE_N, _LEAST_FORCE_N = 1.0, 5e-6
_LEAST_POSITION_M = 2e-4
_MOST_VOLTAGE_V, _LEAST_VOLTAGE_V = 30.0, 0.02
_MOST_LENGTHS = 5.0  # of a curve, in free lengths of its sheet


def doubts(measurements: Measurements) -> Iterator[str]:
    """A sentence for each column whose numbers can hardly be in its unit."""
    conditions = measurements.conditions
    yield from _forces([r.force_N for each in conditions for r in each.readings])
    yield from _positions({each.position_m for each in conditions if each.position_m is not None})
    yield from _voltages({each.voltage_V for each in conditions})
    for name, sheet in measurements.sheets.items():
        yield from _curves(
            name, sheet.free_length_m + sheet.elongation_m, _all_curves(conditions, name)
        )


def _forces(values: list[float]) -> Iterator[str]:
    most_N = max(map(abs, values), default=math.nan)
    if most_N > _MOST_FORCE_N or 0.0 < most_N < _LEAST_FORCE_N:
        yield f"No force is farther from 0 than {1e3 * most_N:g} mN: is force_mN in mN?"


def _positions(values: set[float]) -> Iterator[str]:
    most_m = max(map(abs, values), default=math.nan)
    if len(values) > 1 and most_m < _LEAST_POSITION_M:
        yield f"No position is farther from 0 than {1e3 * most_m:g} mm: is position_mm in mm?"


def _voltages(values: set[float]) -> Iterator[str]:
    most_V = max(map(abs, values), default=math.nan)
    if most_V > _MOST_VOLTAGE_V or 0.0 < most_V < _LEAST_VOLTAGE_V:
        yield f"No voltage is farther from 0 than {most_V:g} V: is voltage_V in V?"


def _all_curves(conditions: Iterable[Condition], configuration: str) -> list[Curve]:
    mine = [each for each in conditions if each.configuration == configuration]
    found = [each.curve for each in mine] + [r.curve for each in mine for r in each.readings]
    return [curve for curve in found if curve is not None]


def _curves(configuration: str, length_m: float, curves: list[Curve]) -> Iterator[str]:
    if not curves:
        return
    longest_m = max(float(np.hypot(np.diff(c.x_m), np.diff(c.y_m)).sum()) for c in curves)
    if not 1 / _MOST_LENGTHS < longest_m / length_m < _MOST_LENGTHS:
        yield (
            f"The longest curve of '{configuration}' has {1e3 * longest_m:.3g} mm, sheet and "
            f"elongation have {1e3 * length_m:.3g} mm: are x_mm and y_mm in mm?"
        )
