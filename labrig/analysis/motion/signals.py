"""A run's voltage as it was written, its force and its current, at the recorded rate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drivers.interfaces import FloatArray
from drivers.load_cell import LoadCellCalibration
from labrig.analysis.edges import find_edges
from labrig.analysis.series import CURRENT
from labrig.session import RecordedSession, RunRecord
from model.dynamics import HeldVoltage
from protocols.execution.channels import DRIVE, FORCE
from protocols.planning.schedule import Purpose

SETTLED_S = 0.005  # after an edge the amplifier's output stands
LONG_AGO_S = 1e4  # before the session the electrodes were at rest for so long


@dataclass(frozen=True, kw_only=True)
class MotionSignals:
    """What the boards recorded of a run; times count from where it is taken to begin."""

    drive: HeldVoltage  # at the amplifier's output; times before 0 are those of the runs before
    time_s: FloatArray  # (n,) of the samples that were not lost
    force_N: FloatArray  # (n,)
    current_A: FloatArray | None  # (n,)


def motion_signals(
    session: RecordedSession,
    run: RunRecord,
    calibration: LoadCellCalibration,
    shunt_ohm: float | None,
    *,
    begin_s: float,
) -> MotionSignals:
    """Return a run from `begin_s` on; the force counts from the load cell's zero."""
    time_s = run.time_s
    force_N = calibration.newtons(run.signal_V(FORCE))
    force_N -= load_cell_zero(session, run, calibration)
    use = (time_s >= begin_s) & np.isfinite(force_N)
    current_A = None
    if CURRENT in run.channels and shunt_ohm is not None:
        current_A = run.signal_V(CURRENT) / shunt_ohm
        use &= np.isfinite(current_A)
    return MotionSignals(
        drive=drive_of(session, run, begin_s),
        time_s=time_s[use] - begin_s,
        force_N=force_N[use],
        current_A=None if current_A is None else current_A[use],
    )


def drive_of(session: RecordedSession, run: RunRecord, begin_s: float) -> HeldVoltage:
    """Return the written voltages at their own times, s after the run's `begin_s`.

    Those of the same sheet's earlier runs come before. The amplifier's offset, as the run's
    read-back shows it, is added: it stands at the sheet all the time.
    """
    zero_s = run.time_zero_s + begin_s
    read_V = run.signal_V(DRIVE)
    times, volts = [-LONG_AGO_S], [0.0]
    for other in session.runs:
        same = other.planned.configuration == run.planned.configuration
        if not (same and other.started and other.time_zero_s <= run.time_zero_s):
            continue
        edges = find_edges(other, read_V if other is run else other.signal_V(DRIVE))
        for write in other.writes:
            at_s = other.sample_clock.time_of(edges[int(write["step"])].index) - zero_s
            if float(write["sheet_V"]) != volts[-1] and at_s > times[-1]:
                times.append(at_s)
                volts.append(float(write["sheet_V"]))
    written = HeldVoltage(np.array(times), np.array(volts))
    return HeldVoltage(written.time_s, written.voltage_V + _offset_V(run, read_V, written, begin_s))


def _offset_V(run: RunRecord, read_V: FloatArray, written: HeldVoltage, begin_s: float) -> float:
    at_s = run.time_s - begin_s
    since_s = at_s - written.time_s[np.searchsorted(written.time_s, at_s, "right") - 1]
    away_V = (read_V - written.at(at_s))[np.isfinite(read_V) & (since_s > SETTLED_S)]
    return float(np.median(away_V)) if away_V.size else 0.0


def load_cell_zero(
    session: RecordedSession, run: RunRecord, calibration: LoadCellCalibration
) -> float:
    """Return the force that the load cell shows without the sheet, N.

    It is that of the no-touch zero nearest in time at the same position, else at any. Without one
    the calibration's offset is all that is known, and it is 0.
    """
    zeros = [one for one in session.runs if one.planned.purpose is Purpose.NO_TOUCH_ZERO]
    zeros = [one for one in zeros if is_whole(one)]
    if not zeros:
        return 0.0

    def distance(one: RunRecord) -> tuple[bool, float]:
        elsewhere = one.planned.position_m != run.planned.position_m
        return elsewhere, abs(one.time_zero_s - run.time_zero_s)

    return float(np.nanmean(calibration.newtons(min(zeros, key=distance).signal_V(FORCE))))


def is_whole(run: RunRecord) -> bool:
    """Whether a run came to its end and nobody declared it invalid."""
    return run.completed and (run.planned.index, None) not in run.standing_marks
