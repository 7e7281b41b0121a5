"""A schedule in which a controller sets the voltage at one place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from protocols.errors import ScheduleError
from protocols.planning.builder import fits
from protocols.planning.schedule import (
    ForceStep,
    PlannedRun,
    Purpose,
    Schedule,
    VoltageStep,
)

_SAME_PLACE_M = 1e-6


def controlled(
    schedule: Schedule,
    configuration: str,
    position_m: float,
    reference: Sequence[ForceStep],
    duration_s: float,
) -> Schedule:
    """Return a schedule with the controlled runs at a place that `schedule` measures.

    What is done by hand before stays; the pulses give way to the reference, which ends at
    `duration_s` with 0 V. Raises ScheduleError when the schedule does not measure there.
    """
    runs = [run for run in schedule.runs if _is_there(run, configuration, position_m)]
    if not runs:
        raise ScheduleError(
            f"the protocol does not measure {configuration} at {1e3 * position_m:g} mm, the place "
            "of the controller"
        )
    steps = (VoltageStep(0.0, 0.0), VoltageStep(duration_s, 0.0))
    within = tuple(step for step in reference if not fits(duration_s, step.time_s))
    return replace(
        schedule,
        runs=tuple(
            replace(
                run,
                index=index,
                purpose=Purpose.CONTROL,
                steps=steps,
                readings=(),
                duration_s=duration_s,
                reference=within,
            )
            for index, run in enumerate(runs)
        ),
        repeats=(),
    )


def _is_there(run: PlannedRun, configuration: str, position_m: float) -> bool:
    return (
        run.measures
        and run.configuration == configuration
        and run.position_m is not None
        and abs(run.position_m - position_m) < _SAME_PLACE_M
    )
