"""Whether the load cell still weighs right: its dead weights against its calibration."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from drivers.load_cell import LoadCellCalibration
from labrig.analysis.forces import ForceReading
from labrig.session import RecordedSession
from protocols.planning.schedule import Purpose

SIGMAS = 3.0
# A hung weight is good to about this part of itself: its hook, its angle, its label.
WEIGHT_SIGMA = 0.005


def dead_weight_warnings(
    session: RecordedSession,
    forces: Mapping[int, Sequence[ForceReading]],
    calibration: LoadCellCalibration,
) -> Iterator[str]:
    """Return a sentence for each dead weight that the load cell, less its zero, read wrongly."""
    means = dict(_means(session, forces))
    zero_N, zero_sigma_N = means.get(0.0, (0.0, 0.0))
    for load_N, (read_N, read_sigma_N) in means.items():
        if load_N == 0.0:
            continue
        off_N = abs(read_N - zero_N) - load_N
        slope_N = load_N * calibration.sensitivity_sigma_V_per_N / calibration.sensitivity_V_per_N
        sigma_N = float(np.hypot(np.hypot(read_sigma_N, zero_sigma_N), slope_N))
        sigma_N = float(np.hypot(sigma_N, WEIGHT_SIGMA * load_N))
        if abs(off_N) > SIGMAS * sigma_N:
            yield (
                f"The load cell reads a dead weight of {load_N * 1e3:.3f} mN as "
                f"{(load_N + off_N) * 1e3:.3f} mN; calibrate it before its forces are trusted."
            )


def _means(
    session: RecordedSession, forces: Mapping[int, Sequence[ForceReading]]
) -> Iterator[tuple[float, tuple[float, float]]]:
    """Load -> mean reading and its standard error, of the runs with dead weights."""
    for run in session.runs:
        load_N = run.planned.load_N
        if run.planned.purpose is not Purpose.DEAD_WEIGHT or load_N is None:
            continue
        read_N = np.array([r.force_N for r in forces.get(run.planned.index, ()) if r.valid])
        if read_N.size:
            spread = float(np.std(read_N, ddof=1)) if read_N.size > 1 else 0.0
            yield load_N, (float(read_N.mean()), spread / read_N.size**0.5)
