"""A schedule in rows for people, and a run as a line to draw."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from drivers.interfaces import Prompt
from protocols.planning.limits import time_under_voltage_s
from protocols.planning.loop_timing import LoopTiming
from protocols.planning.preparation import Action, Move, Situation, preparation
from protocols.planning.schedule import (
    AT_REST_S,
    SETTLED_S,
    PlannedRun,
    Purpose,
    ReadingKind,
    Schedule,
)

# How long things take at the rig, roughly, s: for the estimate only.
TAKES_S = {
    "mount": 180.0,
    "remount": 180.0,
    "moisten": 20.0,
    "touch": 15.0,
    "free": 15.0,
    "dead_weight": 30.0,
    "turn_over": 180.0,
}
MOVE_TAKES_S = 10.0
OTHER_TAKES_S = 10.0


@dataclass(frozen=True, kw_only=True)
class PlanRow:
    """One run, as `labrig plan` shows it."""

    run: int
    purpose: Purpose
    extra: str  # that added it, in words; empty: a run of the protocol itself
    configuration: str
    position_m: float | None
    approach: str
    mounting: int
    prompts: tuple[str, ...]  # what is asked of the operator, or moved, before it
    starts_s: float  # estimated, from the session's beginning
    duration_s: float
    under_voltage_s: float
    voltages_V: tuple[float, ...]  # in the order in which they first appear, 0 left out
    readings: dict[ReadingKind, int]


@dataclass(frozen=True)
class ScheduleDescription:
    """The whole session."""

    rows: tuple[PlanRow, ...]
    running_s: float  # the runs alone
    estimate_s: float  # with everything that is done between them
    under_voltage_s: float


@dataclass(frozen=True, kw_only=True)
class Timeline:
    """A run as a line: `voltage_V[i]` from `time_s[i]` to `time_s[i + 1]`, drawn with corners."""

    time_s: tuple[float, ...]
    voltage_V: tuple[float, ...]
    reading_s: tuple[float, ...]  # sampling points
    reading_V: tuple[float, ...]
    reading_kind: tuple[ReadingKind, ...]


def describe(schedule: Schedule, timing: LoopTiming | None = None) -> ScheduleDescription:
    """Return times, voltages and readings of every run, and an estimate of the session's time."""
    timing = timing or LoopTiming()
    situation, clock_s, rows = Situation(), 0.0, []
    for run in schedule.runs:
        actions, situation = preparation(situation, run)
        clock_s += sum(map(_takes_s, actions)) + timing.lead_in_s
        rows.append(_row(run, actions, clock_s))
        clock_s += run.duration_s + timing.tail_s
    return ScheduleDescription(
        rows=tuple(rows),
        running_s=sum(row.duration_s for row in rows),
        estimate_s=clock_s,
        under_voltage_s=sum(row.under_voltage_s for row in rows),
    )


def free_shapes_in_words(schedule: Schedule) -> str:
    """Return how long the sheet has been at rest when its free shapes are taken; "": none are."""
    names: dict[str, list[str]] = {}
    for run in schedule.runs:
        if run.purpose is Purpose.FREE_SHAPE and run.readings:
            names.setdefault(_rest_in_words(run), []).append(run.configuration)
    return "; ".join(f"{', '.join(dict.fromkeys(which))}: {text}" for text, which in names.items())


def _rest_in_words(run: PlannedRun) -> str:
    return ", ".join(
        [
            *_shapes(run, "at 0 V", driven=False),
            *(_shapes(run, "under voltage", driven=True) or ["none under voltage"]),
        ]
    )


def _shapes(run: PlannedRun, where: str, *, driven: bool) -> list[str]:
    """Return after how long they are taken; nothing where there are none."""
    delays_s = [each.delay_s for each in run.readings if bool(each.voltage_V) is driven]
    if not delays_s:
        return []
    settled_s = SETTLED_S if driven else AT_REST_S
    moving = "" if min(delays_s) >= settled_s else " (the sheet may still swing)"
    return [f"{where} after {min(delays_s):g} s{moving}"]


def timeline(run: PlannedRun) -> Timeline:
    """Return what to draw of a run: corners of the voltage, and the readings."""
    time_s, voltage_V = [0.0], [0.0]
    for step in run.steps:
        time_s += [step.time_s, step.time_s]
        voltage_V += [voltage_V[-1], step.voltage_V]
    return Timeline(
        time_s=(*time_s, run.duration_s),
        voltage_V=(*voltage_V, voltage_V[-1]),
        reading_s=tuple(run.time_of(reading) for reading in run.readings),
        reading_V=tuple(reading.voltage_V for reading in run.readings),
        reading_kind=tuple(reading.kind for reading in run.readings),
    )


def _row(run: PlannedRun, actions: list[Action], starts_s: float) -> PlanRow:
    return PlanRow(
        run=run.index,
        purpose=run.purpose,
        extra=run.in_words if run.extra else "",
        configuration=run.configuration,
        position_m=run.position_m,
        approach=run.approach,
        mounting=run.mounting,
        prompts=tuple(map(_short, actions)),
        starts_s=starts_s,
        duration_s=run.duration_s,
        under_voltage_s=time_under_voltage_s(run),
        voltages_V=tuple(dict.fromkeys(s.voltage_V for s in run.steps if s.voltage_V)),
        readings=dict(Counter(reading.kind for reading in run.readings)),
    )


def _short(action: Action) -> str:
    if isinstance(action, Move):
        return f"move to {action.position_m * 1e3:g} mm"
    if action.load_N is not None:
        return f"{action.kind} {action.load_N * 1e3:g} mN"
    return action.kind


def _takes_s(action: Action) -> float:
    if isinstance(action, Prompt):
        return TAKES_S.get(action.kind, OTHER_TAKES_S)
    return MOVE_TAKES_S
