"""The features of the paper's table 1, each with the question that decides it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from labrig.analysis.features.probe import (
    REST_PER_M,
    SHORT,
    FeatureMark,
    Respond,
    answered,
    bends_unevenly,
    numbers,
    ramp,
    step,
)
from model.measurements import FloatArray

SMALL_V, AT_M, FAR_M = 0.12, 0.005, 0.012
BENT_PER_M = 40.0  # the free sheet turns by 115 degrees
SAME = 1e-6  # relative: rounding


@dataclass(frozen=True)
class Feature:
    """A feature of a model, in words, and how a model is asked for it."""

    name: str
    meaning: str
    asked: str
    ask: Callable[[Respond], str]


def _answer(found: bool | None) -> str:
    if found is None:
        return FeatureMark.UNKNOWN
    return FeatureMark.YES if found else FeatureMark.NO


def _bending(respond: Respond) -> str:
    """Whether curvature varies along a sheet that is held, or else along a free one."""
    for position_m in (FAR_M, None):
        found = answered(respond, step(SMALL_V, position_m, 0.0))
        if found.curves_m is not None:
            x, y = found.curves_m
            return _answer(bends_unevenly(x[-1], y[-1]))
    return FeatureMark.UNKNOWN


def _initial_curvature(respond: Respond) -> str:
    for position_m in (None, AT_M):
        flat, bent = (
            numbers(answered(respond, step(0.0, position_m, k0))) for k0 in (0.0, REST_PER_M)
        )
        shown = [name for name in flat.keys() & bent.keys() if name != "current"]
        if shown:
            return _answer(any(_differ(flat[name], bent[name]) for name in shown))
    return FeatureMark.UNKNOWN


def _large(respond: Respond) -> str:
    """Whether a sheet that turns by more than 90 degrees keeps its length."""
    run = step(0.0, None, BENT_PER_M)
    found = answered(respond, run)
    if found.curves_m is None:
        return FeatureMark.UNKNOWN
    x, y = (one[-1] for one in found.curves_m)
    length = float(np.sum(np.hypot(np.diff(x), np.diff(y))))
    kept = abs(length / run.sheet.free_length_m - 1.0) < 0.02
    return _answer(kept and bool(x[-1] < x[-2]))


def _eibm(respond: Respond) -> str:
    """Whether a slow voltage bends parts of the free sheet differently."""
    found = answered(respond, ramp())
    if found.curves_m is None:
        return FeatureMark.UNKNOWN
    x, y = (one[-1] for one in found.curves_m)
    if not _differ(y, found.curves_m[1][0]):
        return FeatureMark.NO  # it does not follow a voltage
    return _answer(bends_unevenly(x, y))


def _force(respond: Respond) -> str:
    return _answer("force" in numbers(answered(respond, step(1.0, AT_M))))


def _position(respond: Respond) -> str:
    forces = [numbers(answered(respond, step(1.0, at))).get("force") for at in (0.0, 0.01)]
    if forces[0] is None or forces[1] is None:
        return FeatureMark.NO
    return _answer(_differ(forces[0], forces[1]))


def _elongation(respond: Respond) -> str:
    """Whether a short sheet reaches the object with an elongation, and not as well without one."""
    bare = replace(SHORT, elongation_m=0.0)
    longer, shorter = (
        numbers(answered(respond, step(1.0, AT_M, geometry=one))).get("force")
        for one in (SHORT, bare)
    )
    if longer is None:
        return FeatureMark.NO
    return _answer(shorter is None or _differ(longer, shorter))


def _linear(respond: Respond) -> str:
    """Whether twice the voltage has twice the effect on all that is predicted."""
    every: dict[str, bool] = {}
    for position_m, where in ((AT_M, "held"), (None, "free")):
        none, once, twice = (
            numbers(answered(respond, step(volts, position_m))) for volts in (0.0, 1.0, 2.0)
        )
        for name in none.keys() & once.keys() & twice.keys():
            change = once[name] - none[name]
            if np.max(np.abs(change)) > 0.0:
                every[where] = every.get(where, True) and not _differ(
                    twice[name] - none[name], 2.0 * change
                )
    if not every:
        return FeatureMark.UNKNOWN
    yes = [where for where, linear in every.items() if linear]
    return f"{yes[0]} only" if len(yes) == 1 < len(every) else _answer(bool(yes))


def _moves(respond: Respond) -> str:
    """Whether the sheet swings after a step, or at least follows it in time."""
    free = answered(respond, step(1.0, None))
    if free.curves_m is not None and _turns(free.curves_m[1][:, -1]) > 1:
        return "with inertia"
    held = answered(respond, step(1.0, AT_M))
    for found in (free, held):
        for name, values in numbers(found).items():
            early, late = (values[:, i] if name == "curve" else values[i] for i in (1, -1))
            if name != "current" and _differ(early, late):
                return "without inertia"
    return FeatureMark.NO


def _turns(tip: FloatArray) -> int:
    """Return how often the tip turns back by more than 1 % of its range."""
    least, found, far, sign = 0.01 * float(np.ptp(tip)), 0, float(tip[0]), 0
    for at in tip.tolist():
        moved = at - far
        if sign == 0 and abs(moved) > least:
            sign, far = (1 if moved > 0 else -1), at
        elif moved * sign > 0:
            far = at
        elif sign and abs(moved) > least:
            found, sign, far = found + 1, -sign, at
    return found


def _differ(one: FloatArray, other: FloatArray) -> bool:
    scale = max(float(np.max(np.abs(one))), float(np.max(np.abs(other))), 1e-300)
    return bool(np.max(np.abs(one - other)) > SAME * scale)


FEATURES: Final = (
    Feature(
        "non-uniform bending",
        "The curvature may differ along the sheet. A load bends it most at the clamp.",
        "does the curvature of its held (or else free) sheet differ between the two halves?",
        _bending,
    ),
    Feature(
        "initial curvature",
        "The sheet may be curved without force and voltage.",
        "does an initial curvature of 5 per m change its shape or force at 0 V?",
        _initial_curvature,
    ),
    Feature(
        "large deformations",
        "The sheet may turn by more than 90 degrees.",
        "does a free sheet that turns by 115 degrees point back and keep its length?",
        _large,
    ),
    Feature(
        "non-uniform EIBM",
        "The electrically induced bending moment may differ along the sheet.",
        "does a slow ramp of the voltage bend the halves of its free sheet differently?",
        _eibm,
    ),
    Feature(
        "force output",
        "The sheet presses on an object, and the force is predicted.",
        "does it give a force in contact?",
        _force,
    ),
    Feature(
        "varying load position",
        "The object may be anywhere along its arc.",
        "do its forces at 0 and 10 mm differ?",
        _position,
    ),
    Feature(
        "elongation",
        "A rigid straight piece may extend the sheet.",
        "does it give the force of a sheet of 4.5 mm with 40 mm of elongation?",
        _elongation,
    ),
    Feature(
        "linearity",
        "Linear equations describe the sheet, which a controller may need.",
        "has twice the voltage twice the effect on all that it predicts?",
        _linear,
    ),
    Feature(
        "dynamic behaviour",
        "The motion of the sheet is described, not only its states at rest.",
        "does its free sheet swing after a step, or does it at least follow in time?",
        _moves,
    ),
)
