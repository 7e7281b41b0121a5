"""What runs of extras have beyond other runs, beside the schedule.

The schedule is read strictly by programs of before there were extras with runs of their own. So it
holds what they know of a run, and `/session/setup/extras` the rest.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

from labrig.serialise import from_plain, to_plain
from protocols import PlannedMove, PlannedRun, Schedule


@dataclass(frozen=True, kw_only=True)
class _Rest:
    """The fields of a `PlannedRun` that older programs do not know."""

    extra: str = ""
    keep_all_frames: bool = False
    move: PlannedMove | None = None


_NONE: dict[str, Any] = {field.name: field.default for field in fields(_Rest)}


def without_extras(schedule: Schedule) -> Schedule:
    """Return the schedule as older programs read it."""
    return replace(schedule, runs=tuple(replace(run, **_NONE) for run in schedule.runs))


def extras_of(schedule: Schedule) -> dict[str, Any]:
    """Return the rest as plain data, by the run's index; empty where no run has any."""
    rest = {run.index: _rest(run) for run in schedule.runs}
    return {str(index): to_plain(one) for index, one in rest.items() if one != _Rest()}


def with_extras(schedule: Schedule, plain: Any) -> Schedule:
    """Return the schedule with the rest. Raises ValueError for data that are none."""
    found = from_plain(dict[int, _Rest], plain, "extras", lenient=True)
    return replace(
        schedule,
        runs=tuple(
            replace(run, **_values(found[run.index])) if run.index in found else run
            for run in schedule.runs
        ),
    )


def _rest(run: PlannedRun) -> _Rest:
    return _Rest(**_values(run))


def _values(of: PlannedRun | _Rest) -> dict[str, Any]:
    return {name: getattr(of, name) for name in _NONE}
