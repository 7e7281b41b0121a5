"""What is checked of a schedule before any hardware is touched."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import isfinite, pi

from protocols.errors import ScheduleError
from protocols.planning.builder import fits
from protocols.planning.schedule import PlannedReading, PlannedRun, Purpose, Schedule


@dataclass(frozen=True)
class SafetyLimits:
    """What the sheet and the rig stand."""

    sheet_voltage_V: float  # either sign
    time_under_voltage_s: float  # in one run: the sheet dries


def time_under_voltage_s(run: PlannedRun) -> float:
    """How long a run keeps the sheet at a voltage other than 0, s; with a controller, at most."""
    if run.reference:
        return run.steps[-1].time_s - run.steps[0].time_s
    ends_s = [step.time_s for step in run.steps[1:]] + [run.duration_s]
    return sum(
        end_s - step.time_s
        for step, end_s in zip(run.steps, ends_s, strict=True)
        if step.voltage_V != 0.0
    )


def check_schedule(schedule: Schedule, limits: SafetyLimits) -> None:
    """Raise one ScheduleError that names every fault of a schedule, and where it is."""
    faults = [*_general_faults(schedule), *_faults_of_runs(schedule, limits)]
    if faults:
        raise ScheduleError("; ".join(faults))


def positions_m(runs: Iterable[PlannedRun]) -> list[float]:
    """Return all positions along the arc that the load cell is moved to, in increasing order."""
    wanted = list[float | None]()
    for run in runs:
        wanted += [run.via_m, run.position_m, None if run.move is None else run.move.position_m]
    return sorted({position_m for position_m in wanted if position_m is not None})


def check_structure(schedule: Schedule) -> None:
    """Raise one ScheduleError that names every fault that is one whatever the limits."""
    faults = [*_general_faults(schedule), *_faults_of_runs(schedule, None)]
    if faults:
        raise ScheduleError("; ".join(faults))


def _general_faults(schedule: Schedule) -> Iterator[str]:
    if not schedule.runs:
        yield "the schedule has no runs"
    if [run.index for run in schedule.runs] != list(range(len(schedule.runs))):
        yield "the runs are not numbered 0, 1, 2, ..."
    first = len(schedule.runs)
    if [run.index for run in schedule.repeats] != list(range(first, len(schedule.all_runs))):
        yield "the repeats are not numbered after the runs"
    if not {run.repeats for run in schedule.repeats} <= set(range(first)):
        yield "a repeat is of no run of the schedule"
    tilts = {run.tilt_rad for run in schedule.runs}
    if not tilts <= {0.0, pi}:
        yield "a rig stands upright (tilt_rad 0) or is turned over (pi), nothing between"
    elif len(tilts) > 1:
        yield "the rig cannot be turned over between two runs of a session"
    if not (isfinite(schedule.frame_rate_hz) and schedule.frame_rate_hz > 0):
        yield f"frame_rate_hz = {schedule.frame_rate_hz} must be larger than 0"


def _faults_of_runs(schedule: Schedule, limits: SafetyLimits | None) -> list[str]:
    """Each fault once, with the runs that have it; those of the same runs together."""
    where: dict[str, list[PlannedRun]] = {}
    for run in schedule.runs:
        for fault in structure_faults(run):
            where.setdefault(fault, []).append(run)
        for fault in limit_faults(run, limits) if limits else ():
            where.setdefault(fault, []).append(run)
    together: dict[tuple[int, ...], list[str]] = {}
    for fault, runs in where.items():
        together.setdefault(tuple(run.index for run in runs), []).append(fault)
    return [f"{_runs(where[faults[0]])}: {', and '.join(faults)}" for faults in together.values()]


def limit_faults(run: PlannedRun, limits: SafetyLimits) -> Iterator[str]:
    """Yield what of a run is beyond the limits, a phrase each."""
    largest_V = max((abs(step.voltage_V) for step in run.steps), default=0.0)
    if not largest_V <= limits.sheet_voltage_V:
        yield (
            f"{largest_V:g} V at the sheet is beyond the limit of ±{limits.sheet_voltage_V:g} V "
            "([limits] sheet_voltage_V)"
        )
    under_s = time_under_voltage_s(run) if run.steps else 0.0
    if not fits(under_s, limits.time_under_voltage_s):
        yield (
            f"{under_s:g} s under voltage is longer than the limit of "
            f"{limits.time_under_voltage_s:g} s ([limits] time_under_voltage_s)"
        )


def structure_faults(run: PlannedRun) -> Iterator[str]:
    """Yield what of a run makes no sense whatever the limits, a phrase each."""
    times_s = [step.time_s for step in run.steps]
    if not run.steps:
        yield "it has no steps"
        return
    if not all(map(isfinite, (*times_s, run.duration_s, *(s.voltage_V for s in run.steps)))):
        yield "a time or a voltage is not a finite number"
        return
    if times_s[0] != 0.0:
        yield "the first step is not at 0 s"
    if any(later <= earlier for earlier, later in pairwise(times_s)):
        yield "the steps are not in the order of time"
    if run.steps[-1].voltage_V != 0.0:
        yield f"the last step leaves {run.steps[-1].voltage_V:g} V at the sheet"
    if run.duration_s < times_s[-1]:
        yield "it is over before its last step"
    if run.position_m is not None and not isfinite(run.position_m):
        yield "its position is not a finite number"
    if [reading.index for reading in run.readings] != list(range(len(run.readings))):
        yield "the readings are not numbered 0, 1, 2, ..."
    yield from _move_faults(run)
    yield from _faults_of_readings(run)
    yield from _reference_faults(run)
    due_s = [run.time_of(r) for r in run.readings if 0 <= r.step < len(run.steps)]
    if any(later < earlier for earlier, later in pairwise(due_s)):
        yield "the readings are not in the order of time"


def _reference_faults(run: PlannedRun) -> Iterator[str]:
    reference = run.reference
    if bool(reference) is not (run.purpose is Purpose.CONTROL):
        yield "it has a reference for the force without a controller, or a controller without one"
    if not reference:
        return
    if not all(isfinite(step.time_s) and isfinite(step.force_N) for step in reference):
        yield "its reference has a time or a force that is not a finite number"
        return
    if any(step.voltage_V for step in run.steps) or len(run.steps) != 2 or run.readings:
        yield "with a controller it has other steps than to 0 V first and last, or readings"
    if any(later.time_s <= earlier.time_s for earlier, later in pairwise(reference)):
        yield "its reference is not in the order of time"
    if reference[0].time_s != 0.0 or reference[-1].time_s >= run.steps[-1].time_s:
        yield "its reference does not begin at 0 s, or goes on after the last step"


def _move_faults(run: PlannedRun) -> Iterator[str]:
    move = run.move
    if move is None:
        return
    if not (isfinite(move.time_s) and isfinite(move.position_m)):
        yield "where or when the load cell is moved is not a finite number"
    elif run.position_m is None:
        yield "the load cell is away and cannot be moved along the sheet"
    elif any(step.voltage_V for step in run.steps):
        yield "the load cell is moved in a run with voltages; it may be moved at 0 V only"
    elif run.readings:
        yield "the load cell is moved in a run with readings"
    elif not 0.0 <= move.time_s <= run.duration_s:
        yield f"the load cell is moved at {move.time_s:g} s, outside the run"


@dataclass(frozen=True)
class _ReadingFault:
    """What is wrong with a reading, in the words for one and for several of them."""

    one: str
    several: str
    detail: str  # of this reading


def _faults_of_readings(run: PlannedRun) -> Iterator[str]:
    """Yield each fault once, with how many readings have it."""
    found: dict[str, list[tuple[PlannedReading, _ReadingFault]]] = {}
    for reading in run.readings:
        for fault in _reading_faults(run, reading):
            found.setdefault(fault.several, []).append((reading, fault))
    for several, having in found.items():
        reading, first = having[0]
        name = f"reading {reading.index}"
        if len(having) == 1:
            yield f"{name} {first.one}"
        else:
            yield f"{len(having)} readings {several} (the first is {name}, {first.detail})"


def _reading_faults(run: PlannedRun, reading: PlannedReading) -> Iterator[_ReadingFault]:
    if not 0 <= reading.step < len(run.steps):
        one = f"belongs to step {reading.step}, and there is none"
        yield _ReadingFault(one, "belong to steps that are not there", f"of step {reading.step}")
        return
    if not (isfinite(reading.delay_s) and isfinite(reading.half_window_s)):
        rest = "a time that is not a finite number"
        yield _ReadingFault(f"has {rest}", f"have {rest}", f"{reading.delay_s:g} s into its step")
        return
    step = run.steps[reading.step]
    last = reading.step == len(run.steps) - 1
    end_s = run.duration_s if last else run.steps[reading.step + 1].time_s
    lasts = f"its step lasts {end_s - step.time_s:g} s"
    reach_s = reading.delay_s + reading.half_window_s
    if reading.half_window_s < 0 or not fits(reading.half_window_s, reading.delay_s):
        yield _ReadingFault("begins before its step", "begin before their step", lasts)
    if not fits(step.time_s + reach_s, end_s):
        one = f"is not over when its step is, which lasts {end_s - step.time_s:g} s"
        yield _ReadingFault(one, "are not over when their step is", lasts)
    if reading.voltage_V != step.voltage_V:
        one = f"says {reading.voltage_V:g} V, its step {step.voltage_V:g} V"
        yield _ReadingFault(one, "say another voltage than their step", f"which {one}")


def _runs(runs: list[PlannedRun]) -> str:
    first = runs[0]
    at = "" if first.position_m is None else f" at {first.position_m * 1e3:g} mm"
    name = f"run {first.index + 1} ({first.configuration}{at})"
    return name if len(runs) == 1 else f"{name} and {len(runs) - 1} more"
