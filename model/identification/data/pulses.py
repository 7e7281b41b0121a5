"""A recorded series cut into its pulses, and each pulse into parts.

What a force does within a pulse is told from its mean in a few parts of the pulse, less that about
the sampling point: the level is in the readings already.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from model.measurements import FloatArray, ModelError, TimeSeries

SAMPLE_S, WINDOW_S = 0.5, 0.1  # of the sampling point in a pulse, and half its width
BINS_S = np.array([0.15, 0.19, 0.23, 0.28, 0.34, 0.40])  # edges of the parts of a pulse
DISCARDED = 2  # first pulses of a run, as in the paper
STEP_V = 0.25  # smaller changes of the drive are its read-back's noise
FEWEST_SAMPLES = 20


def parts_of_pulses(series: TimeSeries) -> dict[float, FloatArray]:
    """Force in the parts of each kept pulse, (pulses, parts) in N, by the sign of the voltage.

    Pulses in which a part holds no finite sample are left out. A `ModelError` where the clock or
    the drive is not finite.
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
        if driven > DISCARDED and part is not None:
            found.setdefault(float(np.sign(volts)), []).append(part)
    return {sign: np.array(parts) for sign, parts in found.items()}


def _parts(t_s: FloatArray, force_N: FloatArray) -> FloatArray | None:
    """Mean force in each part of a pulse, less that about the sample; None: not recorded."""
    at = force_N[np.abs(t_s - SAMPLE_S) <= WINDOW_S]
    inside = [force_N[(t_s >= low) & (t_s < high)] for low, high in pairwise(BINS_S)]
    if any(not len(values) or not np.all(np.isfinite(values)) for values in (at, *inside)):
        return None
    return np.array([float(np.mean(values)) for values in inside]) - float(np.mean(at))
