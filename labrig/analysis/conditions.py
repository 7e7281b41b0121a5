"""Puts forces and curves of a session together as the model takes them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Literal, cast

from labrig.analysis.curves import ConditionCurves
from labrig.analysis.forces import ForceReading
from labrig.session import RecordedSession, RunRecord
from labrig.session.format.layout import NO_FRAME
from model.measurements import Condition, Kind, Reading
from protocols.planning.schedule import PlannedRun, Purpose

Forces = Mapping[int, Sequence[ForceReading]]  # by run


def conditions_of(
    session: RecordedSession, forces: Forces, curves: Sequence[ConditionCurves]
) -> tuple[Condition, ...]:
    """Return one condition for each run and voltage, in the order of the runs.

    Readings without contact, and those of free shapes, are of kind no_contact and have no position.
    Dead weights are no measurement of the sheet and are left out.
    """
    found = {(each.run, each.voltage_V): each for each in curves}
    turn = turns_of(session)
    begin_s = _begin_s(session)
    made: list[Condition] = []
    for run in session.runs:
        readings = forces.get(run.planned.index, ())
        if run.planned.purpose is Purpose.DEAD_WEIGHT:
            continue
        for voltage_V in dict.fromkeys(reading.voltage_V for reading in readings):
            seen = found.get((run.planned.index, voltage_V))
            made.append(
                Condition(
                    configuration=run.planned.configuration,
                    position_m=_position_m(run.planned),
                    voltage_V=voltage_V,
                    readings=tuple(
                        _readings(run, readings, voltage_V, seen, run.time_zero_s - begin_s)
                    ),
                    curve=None if seen is None else seen.mean,
                    mounting=run.planned.mounting,
                    approach=cast("Literal['up', 'down', '']", run.planned.approach),
                    tilt_rad=run.planned.tilt_rad,
                    run=turn[run.planned.index],
                    contact=None if seen is None else seen.contact,
                )
            )
    return tuple(made)


def _readings(
    run: RunRecord,
    readings: Sequence[ForceReading],
    voltage_V: float,
    curves: ConditionCurves | None,
    run_begin_s: float,
) -> Iterator[Reading]:
    since_wetting_s = run.since_wetting_s
    frame_s = _frame_times_s(run)
    for reading in readings:
        if reading.voltage_V != voltage_V:
            continue
        yield Reading(
            index=reading.index,
            kind=_kind(run.planned, reading),
            force_N=reading.force_N,
            time_s=reading.time_s,
            session_s=run_begin_s + reading.time_s,
            wetted_s=None if since_wetting_s is None else since_wetting_s + reading.time_s,
            valid=reading.valid,
            why=reading.why,
            curve=None if curves is None else curves.by_reading.get(reading.index),
            frame_s=frame_s.get(reading.index),
            other_values=reading.other_values,
        )


def _frame_times_s(run: RunRecord) -> dict[int, float]:
    """Return when the frame of each reading that has one was taken, since the run began."""
    rows = run.readings[run.readings["frame"] != NO_FRAME] if run.started else ()
    if not len(rows):
        return {}
    time_s = run.frame_column("time")
    return {int(row["index"]): float(time_s[int(row["frame"])]) for row in rows}


def _position_m(planned: PlannedRun) -> float | None:
    return planned.position_m if planned.purpose is Purpose.MEASUREMENT else None


def _kind(planned: PlannedRun, reading: ForceReading) -> Kind:
    return reading.kind.value if planned.purpose is Purpose.MEASUREMENT else "no_contact"


def turns_of(session: RecordedSession) -> dict[int, int]:
    """Return for each run how many before it had the same configuration, position and mounting."""
    seen: dict[tuple[str, float | None, int], int] = {}
    turns: dict[int, int] = {}
    for run in session.runs:
        planned = run.planned
        key = (planned.configuration, _position_m(planned), planned.mounting)
        turns[planned.index] = seen.get(key, 0)
        seen[key] = turns[planned.index] + 1
    return turns


def purposes_of(session: RecordedSession) -> dict[tuple[str, float | None, int, int], Purpose]:
    """Return what the run of each condition is for, by what tells its conditions from others.

    That is configuration, position, mounting and turn.
    """
    turns = turns_of(session)
    plans = [run.planned for run in session.runs]
    return {
        (one.configuration, _position_m(one), one.mounting, turns[one.index]): one.purpose
        for one in plans
    }


def _begin_s(session: RecordedSession) -> float:
    """Return clock time at which the session began."""
    return session.events[0].time_s if session.events else 0.0
