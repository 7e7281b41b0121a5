"""A recorded series cut into its pulses, and each pulse into parts.

What a force does within a pulse is told from its mean in a few parts of the pulse, less that about
the sampling point: the level is in the readings already.
"""

from __future__ import annotations

from collections.abc import Collection
from itertools import pairwise

import numpy as np

from model.measurements import FloatArray, ModelError, TimeSeries
from model.measurements.pulse_train import DISCARDED, SAMPLE_S

WINDOW_S = 0.1  # half the width of the sampling point
BINS_S = np.array([0.15, 0.19, 0.23, 0.28, 0.34, 0.40])  # edges of the parts of a pulse
STEP_V = 0.25  # smaller changes of the drive are its read-back's noise
FEWEST_SAMPLES = 20
FAR = 0.3  # of a voltage, from what was asked for


def parts_of_pulses(series: TimeSeries, voltages_V: Collection[float]) -> dict[float, FloatArray]:
    """Force in the parts of each kept pulse, (pulses, parts) in N, by which voltage it has.

    Pulses in which a part holds no finite sample are left out, as are those of other voltages. A
    `ModelError` where the clock or the drive is not finite.
    """
    if series.force_N is None or len(series.time_s) < FEWEST_SAMPLES:
        return {}
    t, drive = np.asarray(series.time_s), np.asarray(series.drive_V)
    force = np.asarray(series.force_N)
    if not (np.all(np.isfinite(t)) and np.all(np.isfinite(drive))):
        raise ModelError(f"the series of {series.configuration} holds a number that is not finite")
    level = np.round(drive / STEP_V)
    starts = np.concatenate([[0], 1 + np.flatnonzero(np.diff(level))])
    starts = starts[np.diff(np.append(t[starts], t[-1])) > 0.8 * SAMPLE_S]
    found: dict[float, list[FloatArray]] = {}
    driven = 0
    for a, b in pairwise([*starts, len(t)]):
        volts = float(np.median(drive[a:b]))
        if abs(volts) < STEP_V:
            continue
        driven += 1
        before = t[a - 1] if a else t[a]  # the edge lies between two samples
        part = _parts(t[a:b] - 0.5 * (before + t[a]), force[a:b])
        asked_V = _nearest(volts, voltages_V)
        if driven > DISCARDED and part is not None and asked_V is not None:
            found.setdefault(asked_V, []).append(part)
    return {asked_V: np.array(parts) for asked_V, parts in found.items()}


def _nearest(volts: float, voltages_V: Collection[float]) -> float | None:
    """Return the voltage that was asked for; None: it is far from all of these."""
    near = [one for one in voltages_V if one and abs(volts / one - 1.0) < FAR]
    return min(near, key=lambda one: abs(volts - one), default=None)


def begin_from_rest(series: TimeSeries) -> bool:
    """Whether the voltage goes back to 0 between the pulses of a series, wherever one follows."""
    if len(series.time_s) < FEWEST_SAMPLES:
        return False
    t, level = np.asarray(series.time_s), np.round(np.asarray(series.drive_V) / STEP_V)
    starts = np.concatenate([[0], 1 + np.flatnonzero(np.diff(level))])
    lasts = np.diff(np.append(t[starts], t[-1:])) > WINDOW_S  # not on the way to another level
    driven = level[starts[lasts]] != 0.0
    first = int(np.argmax(driven)) if len(driven) else 0
    return bool(np.sum(driven) > 1 and not np.any(driven[first + 1 :] & driven[first:-1]))


def _parts(t_s: FloatArray, force_N: FloatArray) -> FloatArray | None:
    """Mean force in each part of a pulse, less that about the sample; None: not recorded."""
    at = force_N[np.abs(t_s - SAMPLE_S) <= WINDOW_S]
    inside = [force_N[(t_s >= low) & (t_s < high)] for low, high in pairwise(BINS_S)]
    if any(not len(values) or not np.all(np.isfinite(values)) for values in (at, *inside)):
        return None
    return np.array([float(np.mean(values)) for values in inside]) - float(np.mean(at))
