"""How B and EIBM settle as positions are added: a fit to what was measured up to each of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from labrig.analysis.results.parameters import plain_parameter
from model import FitOptions, Measurements, ModelError
from model.identification.joint import Joint, joint_fit
from model.identification.observations import observe

Convergence = dict[str, list[dict[str, Any]]]  # by configuration; see `result_of`
Cancelled = Callable[[], bool]


def converging(
    measurements: Measurements,
    known: Convergence | None = None,
    options: FitOptions | None = None,
    cancelled: Cancelled = lambda: False,
) -> Convergence:
    """Fit what was measured up to each position, in the order in which they were measured.

    Steps that `known` has are not computed again: during a run that is all but the last. A step
    that allows no fit says why. `cancelled` is asked before each fit.
    """
    earlier = {
        (name, one["positions"], one["conditions"]): one
        for name, points in (known or {}).items()
        for one in points
    }
    found: Convergence = {}
    for name, count, end in _steps(measurements):
        if cancelled():
            break
        points = found.setdefault(name, [])
        step = earlier.get((name, count, end))
        points.append(step or _step(measurements, name, count, end, options or FitOptions()))
    return found


def _steps(measurements: Measurements) -> list[tuple[str, int, int]]:
    """Return configuration, positions measured so far, and conditions up to there."""
    seen: dict[str, set[tuple[float | None, int, int]]] = {}
    last: dict[tuple[str, int], int] = {}
    for i, condition in enumerate(measurements.conditions):
        own = seen.setdefault(condition.configuration, set())
        if condition.position_m is not None:
            own.add((condition.position_m, condition.mounting, condition.run))
        if own:
            last[condition.configuration, len(own)] = i + 1
    return [(name, count, end) for (name, count), end in sorted(last.items(), key=lambda x: x[1])]


def _step(
    measurements: Measurements, name: str, count: int, end: int, options: FitOptions
) -> dict[str, Any]:
    so_far = replace(measurements, conditions=measurements.conditions[:end])
    newest = measurements.conditions[end - 1].position_m
    point: dict[str, Any] = {
        "positions": count,
        "position_mm": None if newest is None else round(1e3 * newest, 6),
        "conditions": end,
        "B_uNm2": None,
        "EIBM_uNm": {},
        "why": "",
    }
    try:
        joint, n = _fitted(so_far, name, options)
    except ModelError as error:
        return {**point, "why": f"{error}."}
    voltages = sorted({c.voltage_V for c in so_far.conditions if c.configuration == name} - {0.0})
    return {
        **point,
        "B_uNm2": plain_parameter(joint.stiffness(n), 1e6),
        "EIBM_uNm": {
            str(float(v)): plain_parameter(joint.constant_eibm(n, v), 1e6) for v in voltages
        },
    }


def _fitted(measurements: Measurements, name: str, options: FitOptions) -> tuple[Joint, int]:
    """Fit all configurations together, or the one alone while the others do not allow it."""
    present = dict.fromkeys(c.configuration for c in measurements.conditions)
    names = [one for one in measurements.sheets if one in present]
    try:
        return _joint(measurements, names, options), names.index(name)
    except ModelError:
        if len(names) == 1:
            raise
        return _joint(measurements, [name], options), 0


def _joint(measurements: Measurements, names: list[str], options: FitOptions) -> Joint:
    return joint_fit(measurements, [observe(measurements, name) for name in names], options)
