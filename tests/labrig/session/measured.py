"""Made-up measurements with every field in use."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

import numpy as np

from model.measurements import (
    Condition,
    Contact,
    Curve,
    Measurements,
    Reading,
    SheetGeometry,
    TimeSeries,
)


def curve(seed: int, points: int = 30, *, full: bool = True) -> Curve:
    rng = np.random.default_rng(seed)
    s = np.linspace(0, 0.05, points)
    x, y = 0.05 * np.sin(20 * s), 0.05 * (1 - np.cos(20 * s)) + rng.normal(0, 1e-6, points)
    if not full:
        return Curve(s, x, y)
    return Curve(s, x, y, rng.normal(20, 1, points), rng.random(points), rng.random(points))


def readings(rng, count: int, *, curves: bool) -> tuple[Reading, ...]:
    return tuple(
        Reading(
            index=2 * i,
            kind=("zero", "discarded", "kept", "no_contact")[i % 4],
            force_N=float(rng.normal(2e-3, 1e-4)),
            time_s=float(rng.random() * 20) if i != 1 else None,
            session_s=float(rng.random() * 900),
            wetted_s=None if i == 2 else float(rng.random()),
            valid=i != 3,
            why="late, by „5 ms“" if i == 3 else "",
            curve=curve(i) if curves and i % 2 else None,
            other_values={} if i == 4 else {"temperature_degC": float(rng.normal(21.5, 0.1))},
        )
        for i in range(count)
    )


def measurements() -> Measurements:
    rng = np.random.default_rng(5)
    nodes = (np.array([0.0, 0.025, 0.05]), np.array([24.0, 14.6, 6.9]))
    sheets = {
        "long": SheetGeometry("long", 0.05, 0.011, 0.00021, 0.0, 0.04, 0.1, nodes, 0.03, 0.0015),
        "short": SheetGeometry("short", 0.0045, 0.011, 0.00021, 0.04, 0.04, 0.0, None),
    }
    rolls = ((0.039, 0.006, 0.0012), (0.041, 0.004, 0.00121))
    seen = Contact(0.041, 0.0396, 0.0051, 0.2, 0.00505, 3e-5, 0.04, rolls)
    conditions = (
        Condition("long", 0.005, 2.0, readings(rng, 6, curves=True), curve(50), contact=seen),
        Condition("long", 0.005, 2.0, readings(rng, 2, curves=False), None, approach="down"),
        Condition("long", 0.1 / 3, -2.0, readings(rng, 4, curves=False), mounting=2, run=1),
        Condition("short", None, 0.0, (), curve(51), tilt_rad=0.02),
        Condition(
            "short",
            0.0,
            -2.0,
            readings(rng, 5, curves=True),
            curve(52),
            approach="up",
            contact=Contact(0.04, 0.04, 0.0, 0.0, 1e-5, 5e-5, 0.04),
        ),
    )
    time = np.arange(40) / 200
    series = (
        TimeSeries("long", 0.005, time, np.sign(time - 0.1), rng.random(40), rng.random(40)),
        TimeSeries("short", None, time, np.sign(time - 0.1), mounting=1, run=2),
    )
    return Measurements(sheets, conditions, series, "file.h5", "ab" * 32, ("a warning, one",))


def same(a: object, b: object) -> bool:
    """Equal to the last bit, arrays included."""
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.dtype == b.dtype and np.array_equal(a, b, True)
    if is_dataclass(a):
        return type(a) is type(b) and all(
            same(getattr(a, each.name), getattr(b, each.name)) for each in fields(a)
        )
    if isinstance(a, dict):
        return isinstance(b, dict) and list(a) == list(b) and all(same(a[k], b[k]) for k in a)
    if isinstance(a, tuple):
        return isinstance(b, tuple) and len(a) == len(b) and all(map(same, a, b))
    return type(a) is type(b) and a == b
