"""A schedule as plain data (for JSON) and back. Reading is strict: nothing missing, nothing more.

What a field may hold is taken from the dataclasses themselves, so the two cannot drift apart. What
has a default may be missing: a session that was recorded before there was such a field.
"""

from __future__ import annotations

import types
from dataclasses import MISSING, fields, is_dataclass
from enum import Enum
from typing import Any, Union, get_args, get_origin, get_type_hints

from protocols.errors import ScheduleError
from protocols.planning.limits import check_structure
from protocols.planning.schedule import PlannedRun, Schedule


def schedule_to_dict(schedule: Schedule) -> dict[str, Any]:
    """The schedule as dicts, lists, strings, numbers and None."""
    encoded: dict[str, Any] = _encode(schedule)
    return encoded


def schedule_from_dict(data: object) -> Schedule:
    """The schedule that `schedule_to_dict` was given. ScheduleError names the faulty key."""
    schedule = _decode(Schedule, data, "schedule")
    assert isinstance(schedule, Schedule)  # noqa: S101 - for the type checker
    check_structure(schedule)
    return schedule


def run_to_dict(run: PlannedRun) -> dict[str, Any]:
    """One run as plain data."""
    encoded: dict[str, Any] = _encode(run)
    return encoded


def run_from_dict(data: object) -> PlannedRun:
    """The run that `run_to_dict` was given."""
    run = _decode(PlannedRun, data, "run")
    assert isinstance(run, PlannedRun)  # noqa: S101 - for the type checker
    return run


def _encode(value: Any) -> Any:
    if isinstance(value, Enum):
        return value.value
    if is_dataclass(value):
        return {f.name: _encode(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, tuple):
        return [_encode(item) for item in value]
    return value


def _decode(kind: Any, data: Any, where: str) -> Any:
    """`data` as a value of type `kind`; `where` names it in errors."""
    if is_dataclass(kind):
        return _decode_dataclass(kind, data, where)
    if get_origin(kind) in (Union, types.UnionType):
        return _decode_optional(kind, data, where)
    if get_origin(kind) is tuple:
        if not isinstance(data, list):
            raise ScheduleError(f"{where}: a list is wanted, not {data!r}")
        item = get_args(kind)[0]
        return tuple(_decode(item, each, f"{where}[{i}]") for i, each in enumerate(data))
    if issubclass(kind, Enum):
        return _decode_enum(kind, data, where)
    return _decode_plain(kind, data, where)


def _decode_dataclass(kind: Any, data: Any, where: str) -> Any:
    if not isinstance(data, dict):
        raise ScheduleError(f"{where}: a table is wanted, not {data!r}")
    names = [f.name for f in fields(kind)]
    needed = [f.name for f in fields(kind) if f.default is MISSING]
    for name in data:
        if name not in names:
            raise ScheduleError(f"{where}: the key {name!r} is not known")
    for name in needed:
        if name not in data:
            raise ScheduleError(f"{where}: the key {name!r} is missing")
    hints = get_type_hints(kind)
    return kind(**{name: _decode(hints[name], data[name], f"{where}.{name}") for name in data})


def _decode_optional(kind: Any, data: Any, where: str) -> Any:
    if data is None:
        return None
    wanted = next(each for each in get_args(kind) if each is not type(None))
    return _decode(wanted, data, where)


def _decode_enum(kind: type[Enum], data: Any, where: str) -> Enum:
    try:
        return kind(data)
    except ValueError:
        allowed = ", ".join(str(each.value) for each in kind)
        raise ScheduleError(f"{where}: {data!r} is none of {allowed}") from None


def _decode_plain(kind: type, data: Any, where: str) -> Any:
    if kind is float and type(data) is int:
        return float(data)
    if type(data) is not kind:  # a bool is no int here
        raise ScheduleError(f"{where}: a {kind.__name__} is wanted, not {data!r}")
    return data
