"""Made-up measurements with every field in use."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

import numpy as np

from model.measurements import (
    CameraUncertainty,
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
        return Curve(s_m=s, x_m=x, y_m=y)
    return Curve(
        s_m=s,
        x_m=x,
        y_m=y,
        curvature_per_m=rng.normal(20, 1, points),
        sigma_m=rng.random(points),
        curvature_sigma_per_m=rng.random(points),
    )


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
        "long": SheetGeometry(
            configuration="long",
            free_length_m=0.05,
            width_m=0.011,
            thickness_m=0.00021,
            elongation_m=0.0,
            arc_radius_m=0.04,
            arc_origin_rad=0.1,
            initial_curvature=nodes,
            rise_time_s=0.03,
            clamped_length_m=0.0015,
        ),
        "short": SheetGeometry(
            configuration="short",
            free_length_m=0.0045,
            width_m=0.011,
            thickness_m=0.00021,
            elongation_m=0.04,
            arc_radius_m=0.04,
            arc_origin_rad=0.0,
            initial_curvature=None,
        ),
    }
    rolls = ((0.039, 0.006, 0.0012), (0.041, 0.004, 0.00121))
    seen = Contact(
        s_m=0.041,
        x_m=0.0396,
        y_m=0.0051,
        angle_rad=0.2,
        position_m=0.00505,
        position_sigma_m=3e-5,
        radius_m=0.04,
        rolls_m=rolls,
    )
    conditions = (
        Condition(
            configuration="long",
            position_m=0.005,
            voltage_V=2.0,
            readings=readings(rng, 6, curves=True),
            curve=curve(50),
            contact=seen,
        ),
        Condition(
            configuration="long",
            position_m=0.005,
            voltage_V=2.0,
            readings=readings(rng, 2, curves=False),
            curve=None,
            approach="down",
        ),
        Condition(
            configuration="long",
            position_m=0.1 / 3,
            voltage_V=-2.0,
            readings=readings(rng, 4, curves=False),
            mounting=2,
            run=1,
        ),
        Condition(
            configuration="short",
            position_m=None,
            voltage_V=0.0,
            readings=(),
            curve=curve(51),
            tilt_rad=0.02,
        ),
        Condition(
            configuration="short",
            position_m=0.0,
            voltage_V=-2.0,
            readings=readings(rng, 5, curves=True),
            curve=curve(52),
            approach="up",
            contact=Contact(
                s_m=0.04,
                x_m=0.04,
                y_m=0.0,
                angle_rad=0.0,
                position_m=1e-5,
                position_sigma_m=5e-5,
                radius_m=0.04,
            ),
        ),
    )
    time = np.arange(40) / 200
    series = (
        TimeSeries(
            configuration="long",
            position_m=0.005,
            time_s=time,
            drive_V=np.sign(time - 0.1),
            force_N=rng.random(40),
            current_A=rng.random(40),
        ),
        TimeSeries(
            configuration="short",
            position_m=None,
            time_s=time,
            drive_V=np.sign(time - 0.1),
            mounting=1,
            run=2,
        ),
    )
    return Measurements(
        sheets=sheets,
        conditions=conditions,
        series=series,
        source="file.h5",
        checksum="ab" * 32,
        warnings=("a warning, one",),
        camera=CameraUncertainty(scale=4e-4, roll_rad=1e-3, origin_m=2e-6, curve_m=5e-7),
    )


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
