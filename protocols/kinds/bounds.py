"""Check a protocol's fields against the bounds that stand in their metadata."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import Field, fields
from typing import Any, get_args, get_origin, get_type_hints

from protocols.errors import ScheduleError

# Keys of `field(metadata=...)` that bound a number, and the words for them.
_BOUNDS: dict[str, tuple[Callable[[float, float], bool], str]] = {
    "gt": (operator.gt, "must be larger than"),
    "ge": (operator.ge, "must be at least"),
    "lt": (operator.lt, "must be smaller than"),
    "le": (operator.le, "must be at most"),
}
_LENGTHS = {"min_length": "ge", "max_length": "le"}


def require_bounds(protocol: Any) -> None:
    """Raise ScheduleError for the first field whose value is of the wrong type or out of bounds."""
    hints = get_type_hints(type(protocol))
    for field in fields(protocol):
        for fault in _faults(field, hints[field.name], getattr(protocol, field.name)):
            raise ScheduleError(fault)


def require_no_0_V(voltages_V: Sequence[float], is_no: str) -> None:
    """Raise ScheduleError where one of these voltages is 0, saying what 0 V is not: "no pulse"."""
    if 0 in voltages_V:
        entry = voltages_V.index(0)
        comma = decimal_comma(voltages_V, entry)
        raise ScheduleError(
            f"entry {entry + 1} of voltages_V is 0 V, which is {is_no}; leave it out{comma}"
        )


def decimal_comma(voltages_V: Sequence[float], entry: int) -> str:
    """Return a hint where this entry may be the decimals of the one before: 2,0 in place of 2.0."""
    all_whole = all(voltage_V == int(voltage_V) for voltage_V in voltages_V)
    before_V, decimals = voltages_V[entry - 1], voltages_V[entry]
    if not all_whole or entry % 2 == 0 or decimals < 0:
        return ""
    return f", or write {before_V:g}.{decimals:g} if {before_V:g},{decimals:g} is one number"


def _faults(field: Field[Any], hint: Any, value: Any) -> Iterator[str]:
    if get_origin(hint) is tuple:
        yield from _length_faults(field.name, field.metadata, value)
        item, bounds = get_args(hint)[0], field.metadata.get("items", {})
        for entry in value:
            yield from _value_faults(f"an entry of {field.name}", item, entry)
            yield from _bound_faults(f"an entry of {field.name}", bounds, entry)
    else:
        yield from _value_faults(field.name, hint, value)
        yield from _bound_faults(field.name, field.metadata, value)


def _length_faults(name: str, metadata: Mapping[str, Any], value: Any) -> Iterator[str]:
    if not isinstance(value, tuple):
        yield f"{name} = {value!r} must be a tuple"
        return
    for key, bound in _LENGTHS.items():
        if key in metadata and not _BOUNDS[bound][0](len(value), metadata[key]):
            yield f"{name} has {len(value)} entries; {_BOUNDS[bound][1]} {metadata[key]}"


def _value_faults(name: str, hint: Any, value: Any) -> Iterator[str]:
    if hint is int and (isinstance(value, bool) or not isinstance(value, int)):
        yield f"{name} = {value!r} must be a whole number"
    if hint is float and not (_is_number(value) and math.isfinite(value)):
        yield f"{name} = {value} is not a finite number"


def _bound_faults(name: str, metadata: Mapping[str, Any], value: Any) -> Iterator[str]:
    for key, (holds, words) in _BOUNDS.items():
        if key in metadata and _is_number(value) and not holds(value, metadata[key]):
            yield f"{name} = {value:g} {words} {metadata[key]:g}"


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
