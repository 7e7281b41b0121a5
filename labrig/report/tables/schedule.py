"""A schedule as rows of a table."""

from __future__ import annotations

from model.measurements import signed
from protocols import PlannedRun, PlanRow, Schedule, ScheduleDescription


def run_rows(schedule: Schedule) -> list[list[str]]:
    """Step by step, the first measuring run of a schedule: what, from when, volts, readings."""
    run = next((r for r in schedule.runs if r.measures), schedule.runs[0])
    rows = []
    for number, step in enumerate(run.steps):
        readings = [reading for reading in run.readings if reading.step == number]
        kinds = ", ".join(dict.fromkeys(reading.kind.value for reading in readings))
        without = "end" if number == len(run.steps) - 1 else "-"
        rows.append(
            [kinds or without, f"{step.time_s:.2f}", signed(step.voltage_V), _times(run, number)]
        )
    return rows


def _readings(row: PlanRow) -> str:
    counts = " + ".join(f"{count} {kind.value}" for kind, count in row.readings.items())
    return ": ".join(part for part in (row.extra, counts) if part)


def _times(run: PlannedRun, step: int) -> str:
    times = [f"{run.time_of(reading):.2f}" for reading in run.readings if reading.step == step]
    return times[0] + f" ... {times[-1]} ({len(times)})" if len(times) > 2 else " ".join(times)


def overview_rows(plan: ScheduleDescription) -> list[list[str]]:
    """One row for each run: when it starts, where, what is asked before it, what it takes."""
    return [
        [
            str(row.run + 1),
            f"{int(row.starts_s) // 60}:{int(row.starts_s) % 60:02d}",
            row.configuration,
            "free" if row.position_m is None else f"{1e3 * row.position_m:g}",
            ", ".join(row.prompts) or "-",
            _readings(row),
            f"{row.duration_s:.1f}",
            f"{row.under_voltage_s:.1f}",
        ]
        for row in plan.rows
    ]
