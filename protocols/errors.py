"""What a user can get wrong about a protocol or a schedule."""

from __future__ import annotations

import math


class ScheduleError(ValueError):
    """A protocol or a schedule that cannot be run; the text is for the user."""


def require_number(what: str, value: float, *, above: float | None = None) -> None:
    """Raise ScheduleError unless `value` is a finite number, and larger than `above` if given."""
    if not math.isfinite(value):
        raise ScheduleError(f"{what} = {value} is not a finite number")
    if above is not None and value <= above:
        raise ScheduleError(f"{what} = {value:g} must be larger than {above:g}")


def require_count(what: str, value: int, *, least: int) -> None:
    """Raise ScheduleError unless `value` is a whole number of at least `least`."""
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise ScheduleError(f"{what} = {value!r} must be a whole number, {least} or more")
