"""Quality of the recorded data: timing, losses, invalid readings, saturation, noise, drift."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from labrig.analysis.conditions import purposes_of
from labrig.analysis.curves import WITH_CURVES
from labrig.report.data.selection import configurations, place, voltages
from labrig.report.parts.table import Table, fixed, number, volts
from labrig.session import RecordedSession, RunRecord
from model import Condition, Measurements
from model.measurements import FloatArray
from protocols.planning.schedule import Purpose

_RAIL = 0.999  # of the range: a sample there may have been cut off
_LATE_S = 5e-3
MOST_WARNINGS = 8  # of the analysis at the top of the page; beyond that a table has them all


@dataclass(frozen=True)
class Quality:
    """Tables of the quality, and the caveats, a sentence each."""

    tables: tuple[Table, ...]
    remarks: tuple[str, ...]


def quality(session: RecordedSession, measurements: Measurements | None) -> Quality:
    """Look through a session's raw data and what was measured from them."""
    started = [run for run in session.runs if run.started]
    tables: list[Table] = []
    remarks: list[str] = []
    raw = (_timing(started), _losses(session, started), _saturation(started)) if started else ()
    for part in raw:
        tables += part.tables
        remarks += part.remarks
    if measurements is not None:
        for part in (_invalid(measurements), _missing_curves(session, measurements)):
            tables += part.tables
            remarks += part.remarks
        tables.append(_noise(measurements))
    return Quality(tuple(tables), tuple(remarks))


def _timing(runs: list[RunRecord]) -> Quality:
    late_s = _joined([run.writes["lateness_s"] for run in runs])
    frame_s = np.abs(_joined([run.readings["frame_offset_s"] for run in runs]))
    clock_s = np.array([run.sample_clock.start_uncertainty_s for run in runs])
    rows = [
        _spread("lateness of written voltages", late_s),
        _spread("distance of frames from their sampling points", frame_s[np.isfinite(frame_s)]),
        _spread("uncertainty of the first sample's time", clock_s),
    ]
    columns = ("time, ms", "median", "99 %", "largest", "count")
    late = int(np.count_nonzero(late_s > _LATE_S))
    said = f"{late} of {len(late_s)} voltages were written more than {1e3 * _LATE_S:g} ms late."
    return Quality(
        (Table(title="Timing", columns=columns, rows=tuple(rows)),), (said,) if late else ()
    )


def _joined(parts: list[FloatArray]) -> FloatArray:
    return np.concatenate(parts) if parts else np.empty(0)


def _spread(name: str, values_s: FloatArray) -> tuple[str, ...]:
    if not len(values_s):
        return (name, "-", "-", "-", "0")
    ms = 1e3 * values_s
    found = (np.median(ms), np.percentile(ms, 99), np.max(ms))
    return (name, *(fixed(float(value), 3) for value in found), str(len(ms)))


def _losses(session: RecordedSession, runs: list[RunRecord]) -> Quality:
    samples = sum(run.counts.lost_samples for run in runs)
    lost = {
        "taken too slowly": sum(run.counts.frames_dropped for run in runs),
        "incomplete": sum(run.counts.frames_incomplete for run in runs),
        "missed": sum(run.counts.frames_missed for run in runs),
    }
    frames = sum(lost.values())
    grabbed = sum(run.counts.frames_grabbed for run in runs)
    bare = sum(int(np.count_nonzero(run.readings["frame"] < 0)) for run in runs)
    rows = [
        ("samples of each channel", str(sum(run.samples for run in runs)), str(samples)),
        ("frames", str(grabbed), str(frames)),
        *((f"frames, {why}", "", str(count)) for why, count in lost.items() if count),
    ]
    remarks = []
    if samples or frames:
        remarks.append(f"{samples} samples and {frames} frames were lost.")
    if bare and session.frame_shape is not None:
        remarks.append(f"{bare} readings have no frame.")
    return Quality(
        (Table(title="Losses", columns=("data", "acquired", "lost"), rows=tuple(rows)),),
        tuple(remarks),
    )


def _saturation(runs: list[RunRecord]) -> Quality:
    rows, remarks = [], []
    for channel in runs[0].signals:
        name, unit, limit = channel.name, channel.raw_unit, channel.range_V
        largest, hit = 0.0, 0
        for run in runs:
            size = np.abs(run.signal_V(name))
            if np.isfinite(size).any():
                largest = max(largest, float(np.nanmax(size)))
                hit += int(np.count_nonzero(size >= _RAIL * limit))
        share = f"{100 * largest / limit:.0f} %"
        rows.append((name, f"± {limit:g} {unit}", f"{number(largest, 3)} {unit}", share, str(hit)))
        if hit:
            remarks.append(f"{hit} samples of the channel {name} are at the end of its range.")
    columns = ("channel", "range", "largest", "share of the range", "samples at its end")
    table = Table(title="Saturation", columns=columns, rows=tuple(rows))
    return Quality((table,), tuple(remarks))


def _invalid(measurements: Measurements) -> Quality:
    found = Counter(
        (c.configuration, place(c.position_m), volts(c.voltage_V), reading.why or "not stated")
        for c in measurements.conditions
        for reading in c.readings
        if not reading.valid
    )
    if not found:
        return Quality((), ())
    rows = tuple((*key, str(count)) for key, count in found.items())
    columns = ("sheet", "position", "voltage", "reason", "readings")
    total = sum(found.values())
    why = Counter(key[-1] for key in found.elements())
    reasons = "; ".join(f"{count} x {text.rstrip('.')}" for text, count in why.most_common(4))
    said = f"{total} readings are invalid and were left out ({reasons})."
    return Quality((Table(title="Invalid readings", columns=columns, rows=rows),), (said,))


def _missing_curves(session: RecordedSession, measurements: Measurements) -> Quality:
    if session.frame_shape is None:
        return Quality((), ())  # the measurements' own warning says so
    purposes = purposes_of(session)
    wanted = [c for c in measurements.conditions if _purpose(c, purposes) in WITH_CURVES]
    lost = Counter(_name(c) for c in wanted if c.curve is None and c.readings)
    if not lost:
        return Quality((), ())
    names = [name + (f" ({count} times)" if count > 1 else "") for name, count in lost.items()]
    listed = "; ".join(names[:4]) + (" ..." if len(names) > 4 else "")
    said = f"{lost.total()} of {len(wanted)} conditions have no curve: {listed}."
    return Quality((), (said,))


def _purpose(
    condition: Condition, purposes: dict[tuple[str, float | None, int, int], Purpose]
) -> Purpose:
    """Return what the run of a condition is for; one of another session counts as a measurement."""
    key = (condition.configuration, condition.position_m, condition.mounting, condition.run)
    return purposes.get(key, Purpose.MEASUREMENT)


def _name(condition: Condition) -> str:
    at = f"{place(condition.position_m)}, {volts(condition.voltage_V)}"
    return f"{condition.configuration}, {at}"


def _noise(measurements: Measurements) -> Table:
    """Scatter and drift of the force readings, the middle of all conditions of a voltage."""
    rows = []
    for name in configurations(measurements):
        for voltage in voltages(measurements, name):
            found = [
                scatter_and_drift(c)
                for c in measurements.conditions
                if c.configuration == name and c.voltage_V == voltage and len(c.used()) > 2
            ]
            if found:
                scatter_mN, drift_mN = 1e3 * np.array(found).T
                worst = drift_mN[np.argmax(np.abs(drift_mN))]
                cells = (np.median(scatter_mN), np.max(scatter_mN), np.median(drift_mN), worst)
                texts = (fixed(float(cell), 3) for cell in cells)
                rows.append((f"{name}, {volts(voltage)}", *texts))
    columns = ("force, mN", "scatter, median", "largest", "drift in a run, median", "largest")
    note = (
        "Scatter: standard deviation of a condition's readings about their straight line in time. "
        "Drift: change of that line between the first and the last reading."
    )
    return Table(title="Noise and drift", columns=columns, rows=tuple(rows), note=note)


def scatter_and_drift(condition: Condition) -> tuple[float, float]:
    """Of a condition's force readings (at least 3), N: about their line in time, and its change."""
    readings = condition.used()
    force = np.array([reading.force_N for reading in readings])
    time = np.array([float(reading.index) for reading in readings])
    slope, offset = np.polyfit(time - time.mean(), force, 1)
    rest = force - offset - slope * (time - time.mean())
    return float(np.sqrt(np.sum(rest**2) / (len(force) - 2))), float(slope * np.ptp(time))
