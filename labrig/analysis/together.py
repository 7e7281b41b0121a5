"""Measurements of several sessions of the same sheet, as one.

Every session is a mounting of its own, since the sheet and the load cell were set anew in between.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from labrig.errors import BadInputError
from model.measurements import Condition, Measurements, SheetGeometry, geometry_difference

BETWEEN_S = 600.0  # from the end of one session to the beginning of the next, where nobody knows


def together(parts: Sequence[tuple[Path, Measurements]]) -> Measurements:
    """Return all of them; BadInputError where their sheets differ."""
    first_path, whole = parts[0]
    for path, one in parts[1:]:
        for name, sheet in one.sheets.items():
            _check_same(whole.sheets.get(name), sheet, first_path, path)
        mounting = 1 + max((c.mounting for c in whole.conditions), default=-1)
        before = max((c.session for c in whole.conditions), default=0)
        later_s = _end_s(whole) + BETWEEN_S
        whole = replace(
            whole,
            sheets={**one.sheets, **whole.sheets},
            conditions=(
                *whole.conditions,
                *(
                    replace(_moved(c, mounting, later_s), session=before + c.session)
                    for c in one.conditions
                ),
            ),
            series=(
                *whole.series,
                *(replace(s, mounting=s.mounting + mounting) for s in one.series),
            ),
            source=f"{whole.source}, {one.source}",
            warnings=(*whole.warnings, *one.warnings),
            camera=whole.camera.larger(one.camera),
        )
    return whole


def _moved(condition: Condition, mounting: int, later_s: float) -> Condition:
    readings = tuple(
        r if r.session_s is None else replace(r, session_s=r.session_s + later_s)
        for r in condition.readings
    )
    return replace(condition, mounting=condition.mounting + mounting, readings=readings)


def _end_s(measurements: Measurements) -> float:
    times = [r.session_s for c in measurements.conditions for r in c.readings]
    return max((t for t in times if t is not None), default=0.0)


def _check_same(one: SheetGeometry | None, other: SheetGeometry, first: Path, second: Path) -> None:
    if one is None:
        return
    unlike = geometry_difference(one, other)
    if unlike is not None:
        raise BadInputError(
            f"{second}: its {one.configuration} sheet has a {unlike.measure} of {unlike.second}, "
            f"that of {first} {unlike.first}; only sessions of the same sheet can be analysed "
            "together."
        )
    if not _same_rest(one, other):
        raise BadInputError(
            f"{second}: its initial curvature of the {one.configuration} sheet is not that of "
            f"{first}; only sessions of the same sheet can be analysed together."
        )


def _same_rest(one: SheetGeometry, other: SheetGeometry) -> bool:
    a, b = one.initial_curvature, other.initial_curvature
    if a is None or b is None:
        return a is b
    return all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))
