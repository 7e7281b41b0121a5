"""A schedule as plain data (for JSON) and back. Reading is strict: nothing missing, nothing more.

What has a default may be missing: a session that was recorded before there was such a field.
"""

from __future__ import annotations

from typing import Any, TypeVar

from protocols.errors import ScheduleError
from protocols.planning.limits import check_structure
from protocols.planning.schedule import PlannedRun, Schedule
from protocols.serialise import SerialiseError, from_plain, to_plain

Part = TypeVar("Part", Schedule, PlannedRun)


def schedule_to_dict(schedule: Schedule) -> dict[str, Any]:
    """Return the schedule as dicts, lists, strings, numbers and None."""
    plain: dict[str, Any] = to_plain(schedule)
    return plain


def schedule_from_dict(data: object) -> Schedule:
    """Return the schedule that `schedule_to_dict` was given. ScheduleError names the faulty key."""
    schedule = _read(Schedule, data, "schedule")
    check_structure(schedule)
    return schedule


def run_to_dict(run: PlannedRun) -> dict[str, Any]:
    """Return one run as plain data."""
    plain: dict[str, Any] = to_plain(run)
    return plain


def run_from_dict(data: object) -> PlannedRun:
    """Return the run that `run_to_dict` was given. Raises ScheduleError."""
    return _read(PlannedRun, data, "run")


def _read(kind: type[Part], data: object, where: str) -> Part:
    try:
        return from_plain(kind, data, where)
    except SerialiseError as error:
        raise ScheduleError(str(error)) from None
