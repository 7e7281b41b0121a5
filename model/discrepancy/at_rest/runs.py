"""Divide measurements into runs: the drive, and the conditions and series of each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from model.dynamics import HeldVoltage
from model.measurements import Condition, FloatArray, Measurements, Reading, TimeSeries
from model.measurements.pulse_train import PULSE_S, SAMPLE_S

CHANGE_V = 0.05  # between two samples of a drive: more is an edge, less its noise


@dataclass(frozen=True, kw_only=True)
class DrivenRun:
    """One run of one configuration."""

    configuration: str
    position_m: float | None  # None: free
    conditions: tuple[int, ...]  # places among those of the measurements
    series: tuple[int, ...]
    drive: HeldVoltage
    begin_s: float  # when the first of drive and readings begins; the sheet was at rest before


def driven_runs(measurements: Measurements, configuration: str) -> Iterator[DrivenRun]:
    """Yield the runs of a configuration that have readings, which tell their times."""
    every = measurements.conditions
    own: dict[tuple[object, ...], list[int]] = {}
    for place, one in enumerate(every):
        if one.configuration == configuration and one.readings:
            own.setdefault((*_place(one), one.approach, one.tilt_rad, one.session), []).append(
                place
            )
    for key, places in own.items():
        series = tuple(
            i for i, s in enumerate(measurements.series)
            if s.configuration == configuration and not s.extra and _place(s) == key[:3]
        )  # fmt: skip
        conditions = [every[i] for i in places]
        recorded = [measurements.series[i] for i in series if len(measurements.series[i].time_s)]
        drive = recorded_drive(recorded[0]) if recorded else planned_drive(conditions)
        times = [at_s(r) - SAMPLE_S for c in conditions for r in c.readings]
        yield DrivenRun(
            configuration=configuration, position_m=conditions[0].position_m,
            conditions=tuple(places), series=series, drive=drive,
            begin_s=min([*times, float(drive.time_s[0])]),
        )  # fmt: skip


def at_s(reading: Reading) -> float:
    """Return when a reading was taken, s since its run began."""
    return reading.index * PULSE_S + SAMPLE_S if reading.time_s is None else reading.time_s


def frame_at_s(reading: Reading) -> float:
    """Return the middle of the exposure that shows a reading's curve, likewise."""
    return at_s(reading) if reading.frame_s is None else reading.frame_s


def recorded_drive(series: TimeSeries) -> HeldVoltage:
    """Return the recorded drive, each stretch without an edge at its mean voltage.

    A sample is the mean over the time about it, so one across an edge tells when that was.
    """
    time, volts = np.asarray(series.time_s, dtype=float), np.asarray(series.drive_V, dtype=float)
    step = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    first = np.concatenate([[0], 1 + np.flatnonzero(np.abs(np.diff(volts)) > CHANGE_V)])
    count = np.diff(np.append(first, len(volts)))
    begin, held = time[first] - 0.5 * step, np.add.reduceat(volts, first) / count
    across = np.zeros(len(held), dtype=bool)
    before, after = held[:-2], held[2:]
    share = (held[1:-1] - after) / np.where(before == after, np.inf, before - after)
    across[1:-1] = (count[1:-1] == 1) & (share > 0.0) & (share < 1.0)
    begin[2:] = np.where(across[1:-1], begin[1:-1] + step * share, begin[2:])
    return HeldVoltage(begin[~across], held[~across])


def planned_drive(conditions: list[Condition]) -> HeldVoltage:
    """Return the drive that readings tell: each is taken half a second after an edge.

    Pulses of which nothing was kept, between two readings, take turns with those that follow.
    """
    readings = sorted((at_s(r), c.voltage_V) for c in conditions for r in c.readings)
    times, volts = (np.array(v) for v in zip(*readings, strict=True))
    slots = np.round((times - times[0]) / PULSE_S).astype(int)
    last = int(slots[-1])
    by_slot = np.full(last + 1, np.nan)
    by_slot[slots] = volts
    for slot in range(last, -1, -1):
        if np.isnan(by_slot[slot]):
            later = by_slot[slot + 2] if slot + 2 <= last else by_slot[slot + 1]
            by_slot[slot] = later
    begins = times[0] - SAMPLE_S + PULSE_S * np.arange(last + 1)
    begins[slots] = times - SAMPLE_S
    return _without_repeats(begins, by_slot)


def _without_repeats(begins: FloatArray, volts: FloatArray) -> HeldVoltage:
    new = np.concatenate([[True], np.diff(volts) != 0.0])
    return HeldVoltage(begins[new], volts[new])


def _place(one: Condition | TimeSeries) -> tuple[object, ...]:
    return one.position_m, one.mounting, one.run
