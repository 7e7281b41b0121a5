"""Columns of imported tables that can hardly be what their names say: a sentence each."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator

import numpy as np

from labrig.plausibility.set_up import length_checks
from model.measurements import Condition, Curve, FloatArray, Measurements, SheetGeometry

# Far beyond what a sheet on such a rig does, and far below what its load cell and stage resolve.
LARGEST_FORCE_N, SMALLEST_FORCE_N = 1.0, 5e-6
SMALLEST_POSITION_M = 2e-4
LARGEST_VOLTAGE_V, SMALLEST_VOLTAGE_V = 30.0, 0.02
LARGEST_LENGTH_RATIO = 5.0  # of a curve, in free lengths of its sheet
LARGEST_BEGIN_RATIO = 0.2  # of the way from the clamp to where curves begin, in the same
# What lies closer was set alike and then measured.
MEASURED_V, MEASURED_M = 0.02, 5e-5
SLOWEST_SAMPLE_S = 0.5  # slower signals show nothing of pulses of the paper's length
MEASURED_COUNT = 3  # so many values more than were set cannot be slips


def table_warnings(measurements: Measurements) -> Iterator[str]:
    """Yield a sentence for each column of imported tables that seems to be something else.

    That is another unit, another origin, or what was measured in place of what was set.
    """
    conditions = measurements.conditions
    positions_m = {each.position_m for each in conditions if each.position_m is not None}
    voltages_V = {each.voltage_V for each in conditions}
    yield from _forces([r.force_N for each in conditions for r in each.readings])
    yield from _positions(positions_m)
    yield from _voltages(voltages_V)
    yield from _measured("position_mm", positions_m, MEASURED_M)
    yield from _measured("voltage_V", voltages_V, MEASURED_V)
    yield from _times([one.time_s for one in measurements.series])
    used = {each.configuration for each in conditions}
    yield from _lengths(sheet for name, sheet in measurements.sheets.items() if name in used)
    for name, sheet in measurements.sheets.items():
        yield from _curves(
            name, sheet.free_length_m + sheet.elongation_m, _all_curves(conditions, name)
        )


def _lengths(sheets: Iterable[SheetGeometry]) -> Iterator[str]:
    found = {check.name: check for sheet in sheets for check in length_checks(sheet)}
    for check in found.values():
        yield f"{check.name} is {check.found}, usual is {check.wanted}: is its unit right?"


def field_warnings(measurements: Measurements) -> Iterator[str]:
    """Yield the same sentences of measurements that somebody made in Python, with their fields."""
    for sentence in table_warnings(measurements):
        said = re.sub(r"\b(force|position|x|y)_m(m|N)( in m(m|N))?", _as_field, sentence)
        yield re.sub(r"sheet\.toml \[(.+?)\] (\w+)_mm", r"sheets['\1'].\2_m", said)


def _as_field(column: re.Match[str]) -> str:
    name, unit, has_unit, _ = column.groups()
    in_SI = "N" if unit == "N" else "m"
    return f"{name}_{in_SI}{f' in {in_SI}' if has_unit else ''}"


def _forces(values: list[float]) -> Iterator[str]:
    largest_N = max(map(abs, values), default=math.nan)
    if largest_N > LARGEST_FORCE_N:
        yield f"The forces reach {1e3 * largest_N:g} mN: is force_mN in mN?"
    if 0.0 < largest_N < SMALLEST_FORCE_N:
        yield f"No force is farther from 0 than {1e3 * largest_N:g} mN: is force_mN in mN?"


def _times(runs: list[FloatArray]) -> Iterator[str]:
    steps_s = np.concatenate([np.zeros(0), *(np.diff(time_s) for time_s in runs)])
    if len(steps_s) and np.median(steps_s) >= SLOWEST_SAMPLE_S:
        whole_s = max(float(np.ptp(time_s)) for time_s in runs)
        yield (
            f"The signals have a sample every {np.median(steps_s):g} s, a run of up to "
            f"{whole_s:g} s: is time_s in s?"
        )


def _positions(values: set[float]) -> Iterator[str]:
    largest_m = max(map(abs, values), default=math.nan)
    if len(values) > 1 and largest_m < SMALLEST_POSITION_M:
        yield f"No position is farther from 0 than {1e3 * largest_m:g} mm: is position_mm in mm?"


def _voltages(values: set[float]) -> Iterator[str]:
    largest_V = max(map(abs, values), default=math.nan)
    if largest_V > LARGEST_VOLTAGE_V:
        yield f"The voltages reach {largest_V:g} V: is voltage_V in V?"
    if 0.0 < largest_V < SMALLEST_VOLTAGE_V:
        yield f"No voltage is farther from 0 than {largest_V:g} V: is voltage_V in V?"


def _measured(column: str, values: set[float], apart: float) -> Iterator[str]:
    """Ask where many values lie so close that they were set alike."""
    groups = 1 + int(np.count_nonzero(np.diff(sorted(values)) > apart))
    if len(values) >= max(2 * groups, groups + MEASURED_COUNT):
        yield (
            f"{column} has {len(values)} values in {groups} group{'s' * (groups > 1)}: was it "
            "measured? Give what was set, the same number in all readings of one condition; else "
            "each of them is a condition of its own, and their scatter is not known."
        )


def _all_curves(conditions: Iterable[Condition], configuration: str) -> list[Curve]:
    mine = [each for each in conditions if each.configuration == configuration]
    found = [each.curve for each in mine] + [r.curve for each in mine for r in each.readings]
    return [curve for curve in found if curve is not None]


def _curves(configuration: str, length_m: float, curves: list[Curve]) -> Iterator[str]:
    if not curves:
        return
    longest_m = max(float(np.hypot(np.diff(c.x_m), np.diff(c.y_m)).sum()) for c in curves)
    if not 1 / LARGEST_LENGTH_RATIO < longest_m / length_m < LARGEST_LENGTH_RATIO:
        yield (
            f"The longest curve of '{configuration}' has {1e3 * longest_m:.3g} mm, sheet and "
            f"elongation have {1e3 * length_m:.3g} mm: are x_mm and y_mm in mm?"
        )
        return
    x_m, y_m = np.median([(c.x_m[0], c.y_m[0]) for c in curves], axis=0)
    if math.hypot(x_m, y_m) > LARGEST_BEGIN_RATIO * length_m:
        yield (
            f"The curves of '{configuration}' begin at x = {1e3 * x_m:.3g} mm, y = {1e3 * y_m:.3g} "
            "mm: do x_mm and y_mm count from the clamp, and their points from there on?"
        )
