"""Whether a force sensor that is asked for one force at a time keeps its contract."""

from __future__ import annotations

import math

from drivers.conformance import Checks
from drivers.interfaces import FORCE_GAP_S, Clock, ForceSensor

READ_S = 2.0
OPEN_S = 10.0
METHODS = ("open", "read_force", "tare", "close")
_READINGS = 5


def force_sensor_faults(sensor: ForceSensor, clock: Clock, *, noise_N: float = 1e-3) -> list[str]:
    """Return what a sensor, not open yet, does against `ForceSensor`.

    The load must be steady, within its range. After taring a reading may be off by `noise_N`.
    """
    checks = Checks(clock)
    if not checks.has(sensor, METHODS):
        return checks.faults
    checks.refuse("read_force before open", sensor.read_force, within_s=READ_S)
    checks.call("open", sensor.open, OPEN_S)
    if not checks.faults:
        checks.identify(sensor)
        _read(checks, sensor, noise_N)
    checks.call("close", sensor.close, READ_S)
    checks.call("a second close", sensor.close)
    checks.refuse("read_force after close", sensor.read_force, within_s=READ_S)
    return checks.faults


def _read(checks: Checks, sensor: ForceSensor, noise_N: float) -> None:
    range_N = sensor.range_N
    checks.require(math.isfinite(range_N) and range_N > 0, f"range_N is {range_N}")
    took_s = []
    for _ in range(_READINGS):
        began_s = checks.clock.now()
        force_N = checks.call("read_force", sensor.read_force, READ_S)
        if checks.is_silent():  # each further call would wait as long for the same answer
            return
        took_s.append(checks.clock.now() - began_s)
        if not checks.answered:
            continue
        if not isinstance(force_N, float):
            checks.note(f"read_force returned {force_N!r}; a float in N is needed")
            continue
        checks.require(
            abs(force_N) <= range_N, f"read_force returned {force_N!r}; the range is {range_N:g} N"
        )
    usual_s = sorted(took_s)[_READINGS // 2]
    checks.require(
        usual_s <= FORCE_GAP_S,
        f"read_force takes {usual_s:.2f} s; the force between two readings is a straight line, so "
        f"{FORCE_GAP_S:g} s is the most",
    )
    checks.call("tare", sensor.tare, READ_S)
    if checks.is_silent():
        return
    force_N = checks.call("read_force", sensor.read_force, READ_S)
    if isinstance(force_N, float):
        checks.require(abs(force_N) <= noise_N, f"after tare it reads {force_N:g} N")
