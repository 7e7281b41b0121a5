"""The signals of a run over time, with fewer samples."""

from __future__ import annotations

import numpy as np

from drivers.interfaces import FloatArray
from drivers.load_cell import LoadCellCalibration
from labrig.session import RunRecord
from model.measurements import TimeSeries

SERIES_HZ = 200.0
CURRENT = "current"


def time_series(
    run: RunRecord,
    calibration: LoadCellCalibration,
    shunt_ohm: float | None,
    turn: int = 0,
    rate_hz: float = SERIES_HZ,
) -> TimeSeries:
    """Return means over blocks of samples, about `rate_hz` of them a second.

    Their times are the middles.

    A block with a lost sample is left out. A sheet that nothing touches has no force. `turn`
    counts runs at the same place.
    """
    block = max(1, round(run.sample_clock.rate_hz / rate_hz))
    time_s = _means(run.time_s, block)
    drive_V = _means(run.signal_V("drive"), block)
    force_N = calibration.newtons(_means(run.signal_V("force"), block))
    current_A = None
    if CURRENT in run.channels and shunt_ohm is not None:
        current_A = _means(run.signal_V(CURRENT), block) / shunt_ohm
    whole = np.isfinite(drive_V) & np.isfinite(force_N)
    touches = run.planned.position_m is not None
    return TimeSeries(
        configuration=run.planned.configuration,
        position_m=run.planned.position_m,
        time_s=time_s[whole],
        drive_V=drive_V[whole],
        force_N=force_N[whole] if touches else None,
        current_A=None if current_A is None else current_A[whole],
        mounting=run.planned.mounting,
        run=turn,
        extra=run.planned.extra,
    )


def _means(samples: FloatArray, block: int) -> FloatArray:
    whole = len(samples) // block * block
    means: FloatArray = samples[:whole].reshape(-1, block).mean(axis=1)
    return means
