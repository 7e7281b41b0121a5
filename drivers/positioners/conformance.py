"""Whether a positioner keeps its contract."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from drivers.conformance import Checks
from drivers.interfaces import Clock, LimitedTravel, LimitError, Positioner

MOVE_S = 300.0
OPEN_S = 120.0  # it may sweep to its reference
BEYOND_M = 1e-3
LARGEST_TRAVEL_M = 5.0  # what is longer is in another unit
METHODS = ("open", "move_to", "position", "close")


def positioner_faults(
    positioner: Positioner,
    clock: Clock,
    positions_m: Sequence[float] = (0.0, 0.01, 0.002),
    *,
    outside_m: float | None = None,
    tolerance_m: float = 1e-4,
) -> list[str]:
    """Return what a positioner, not open yet, does against `Positioner`.

    It moves to `positions_m`: nothing may stand in its way, and an operator must confirm.
    `outside_m` is out of its range; None: it has none, or states it itself (`LimitedTravel`).
    """
    checks = Checks(clock)
    if not checks.has(positioner, METHODS):
        return checks.faults
    checks.call("open", positioner.open, OPEN_S)
    if not checks.faults:
        checks.identify(positioner)
        _move_and_refuse(checks, positioner, positions_m, outside_m, tolerance_m)
    checks.call("close", positioner.close, 5.0)
    checks.call("a second close", positioner.close)
    return checks.faults


def _move_and_refuse(
    checks: Checks,
    positioner: Positioner,
    positions_m: Sequence[float],
    outside_m: float | None,
    tolerance_m: float,
) -> None:
    """Stop at the first time-out: each call after it would wait as long for the same answer."""
    for position_m in positions_m:
        _move(checks, positioner, position_m, tolerance_m)
        if checks.is_silent():
            return
    for refused_m in (math.nan, outside_m, *_beyond_travel(checks, positioner)):
        if refused_m is not None and not checks.is_silent():
            _refuse(checks, positioner, refused_m)


def _beyond_travel(checks: Checks, positioner: Positioner) -> tuple[float, ...]:
    """Return a position beyond each end of the travel that it states; none: it states none."""
    if not isinstance(positioner, LimitedTravel):
        return ()
    stated: object = checks.call("travel_m", positioner.travel_m, 1.0)
    if not checks.answered:
        return ()
    ends_m = two_numbers(stated)
    if ends_m is None:
        checks.note(f"travel_m returned {stated!r}, not the lower and the upper end in m")
        return ()
    low_m, high_m = ends_m
    checks.require(low_m < high_m, f"travel_m returned {low_m:g} to {high_m:g}, lower end first")
    if not checks.require(
        abs(high_m - low_m) <= LARGEST_TRAVEL_M,
        f"its travel is {low_m:g} to {high_m:g} m: is it in mm?",
    ):
        return ()
    return low_m - BEYOND_M, high_m + BEYOND_M


def two_numbers(stated: Any) -> tuple[float, float] | None:
    """Return both ends of a travel; None: it is not two finite numbers."""
    try:
        low, high = map(float, stated)
    except (TypeError, ValueError):
        return None
    return (low, high) if math.isfinite(low) and math.isfinite(high) else None


def _move(checks: Checks, positioner: Positioner, position_m: float, tolerance_m: float) -> None:
    what = f"move_to({position_m:g})"
    moved = checks.call(what, lambda: positioner.move_to(position_m), MOVE_S)
    if not checks.answered:
        return
    checks.require(moved is True, f"{what} returned {moved}, not True")
    found_m = checks.call("position", positioner.position, 5.0)
    if found_m is not None:
        checks.require(
            abs(found_m - position_m) <= tolerance_m, f"after {what} position is {found_m:g}"
        )


def _refuse(checks: Checks, positioner: Positioner, position_m: float) -> None:
    before_m = checks.call("position", positioner.position, 5.0)
    if checks.is_silent():
        return
    knows_where = checks.answered
    what = f"move_to({position_m:g})"
    refused = checks.refuse(what, lambda: positioner.move_to(position_m), LimitError, 5.0)
    if checks.is_silent() or not refused:
        return
    after_m = checks.call("position", positioner.position, 5.0)
    if knows_where and checks.answered:
        checks.require(after_m == before_m, f"{what} was refused, but it moved")
