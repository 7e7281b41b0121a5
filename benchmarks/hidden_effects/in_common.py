"""What several sessions of one design hold alike: what is hidden may take readings away."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import replace

from model.measurements import Condition, Measurements, Reading

WHY = "another session lacks it"
Key = tuple[Hashable, ...]


def in_common(sessions: Sequence[Measurements]) -> list[Measurements]:
    """Return the sessions with the conditions, valid readings and curves that all of them have.

    A session that has no more than the others is returned as it is.
    """
    shared = frozenset.intersection(*(_held(one) for one in sessions))
    return [one if _held(one) == shared else _only(one, shared) for one in sessions]


def _held(one: Measurements) -> frozenset[Key]:
    """Return keys of everything of use."""
    keys: set[Key] = set()
    for c in one.conditions:
        place = _place(c)
        keys |= {(place,), *([(place, "curve")] if c.curve is not None else [])}
        for r in c.readings:
            if r.valid:
                own = (place, r.index, r.kind)
                keys |= {own, *([(*own, "curve")] if r.curve is not None else [])}
    return frozenset(keys)


def _place(c: Condition) -> Key:
    return c.configuration, c.position_m, c.voltage_V, c.mounting, c.approach, c.tilt_rad, c.run


def _only(one: Measurements, shared: frozenset[Key]) -> Measurements:
    conditions = []
    for c in one.conditions:
        place = _place(c)
        if (place,) in shared:
            readings = tuple(_reading(r, place, shared) for r in c.readings)
            curve = c.curve if (place, "curve") in shared else None
            conditions.append(replace(c, readings=readings, curve=curve))
    return replace(one, conditions=tuple(conditions))


def _reading(r: Reading, place: Key, shared: frozenset[Key]) -> Reading:
    if not r.valid:
        return r
    own = (place, r.index, r.kind)
    if own not in shared:
        return replace(r, valid=False, why=WHY)
    return r if (*own, "curve") in shared else replace(r, curve=None)
