"""Mistakes that people make in what they state of a measurement, as changes of good data."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from model.measurements import Condition, Curve, Measurements, Reading, SheetGeometry

Random = np.random.Generator
Made = tuple[Measurements, float]  # with the mistake in it, and the value that would be right


@dataclass(frozen=True)
class Mistake:
    """A mistake, and the data check that should tell it."""

    name: str
    told_by: tuple[str, ...]  # names of checks, any of which is right
    make: Callable[[Measurements, Random], Made]
    tolerance: float = np.inf  # of the value told, relative


def _sheets(m: Measurements, change: Callable[[SheetGeometry], SheetGeometry]) -> Measurements:
    return replace(m, sheets={name: change(sheet) for name, sheet in m.sheets.items()})


def _conditions(m: Measurements, change: Callable[[Condition], Condition]) -> Measurements:
    return replace(m, conditions=tuple(change(c) for c in m.conditions))


def _forces(c: Condition, change: Callable[[float], float]) -> Condition:
    readings = (replace(r, force_N=change(r.force_N)) for r in c.readings)
    return replace(c, readings=tuple(readings))


def _curves(c: Condition, change: Callable[[Curve], Curve]) -> Condition:
    def of(curve: Curve | None) -> Curve | None:
        return None if curve is None else change(curve)

    readings = tuple(replace(r, curve=of(r.curve)) for r in c.readings)
    return replace(c, readings=readings, curve=of(c.curve))


def _points(x: float, y: float, s: float) -> Callable[[Curve], Curve]:
    def scaled(curve: Curve) -> Curve:
        return Curve(s_m=s * curve.s_m, x_m=x * curve.x_m, y_m=y * curve.y_m)

    return scaled


def _positions(factor: float, only: str = "") -> Callable[[Measurements, Random], Made]:
    def change(c: Condition) -> Condition:
        if c.position_m is None or (only and c.configuration != only):
            return c
        return replace(c, position_m=c.position_m * factor)

    return lambda m, _: (replace(_conditions(m, change), series=()), 1.0 / factor)


def _reversed(m: Measurements, _: Random) -> Made:
    places = [c.position_m for c in m.conditions if c.position_m is not None]
    both = min(places) + max(places)

    def change(c: Condition) -> Condition:
        return c if c.position_m is None else replace(c, position_m=both - c.position_m)

    return replace(_conditions(m, change), series=()), np.nan


def _two_positions(*, curves_alone: bool) -> Callable[[Measurements, Random], Made]:
    """Exchange the curves of two positions next to each other, or all that is measured there."""

    def make(m: Measurements, random: Random) -> Made:
        places = sorted({c.position_m for c in m.conditions if c.position_m is not None})
        first = int(random.integers(len(places) - 1))
        other = {places[first]: places[first + 1], places[first + 1]: places[first]}

        def key(c: Condition) -> tuple[object, ...]:
            return c.configuration, c.voltage_V, c.approach, c.tilt_rad

        curves = {(c.position_m, *key(c)): c.curve for c in m.conditions}

        def change(c: Condition) -> Condition:
            if c.position_m is None or c.position_m not in other:
                return c
            there = other[c.position_m]
            if not curves_alone:
                return replace(c, position_m=there)
            readings = tuple(replace(r, curve=None) for r in c.readings)
            return replace(c, curve=curves.get((there, *key(c)), c.curve), readings=readings)

        return replace(_conditions(m, change), series=()), np.nan

    return make


def _leads_at_one_position(m: Measurements, random: Random) -> Made:
    places = sorted({c.position_m for c in m.conditions if c.position_m is not None})
    odd = places[int(random.integers(len(places)))]

    def change(c: Condition) -> Condition:
        return replace(c, voltage_V=-c.voltage_V) if c.position_m == odd else c

    return replace(_conditions(m, change), series=()), np.nan


def _polarity(of: str, only: str = "") -> Callable[[Measurements, Random], Made]:
    """Exchange the curves, or the forces, of opposite voltages."""

    def make(m: Measurements, _: Random) -> Made:
        def key(c: Condition, sign: float) -> tuple[object, ...]:
            place = c.configuration, c.position_m, c.mounting, c.run, c.approach, c.tilt_rad
            return *place, sign * c.voltage_V

        by = {key(c, 1.0): c for c in m.conditions}

        def change(c: Condition) -> Condition:
            other = by.get(key(c, -1.0))
            if other is None or c.voltage_V == 0.0 or (only and c.configuration != only):
                return c
            if of == "curves":
                curve = other.curve
                pairs = zip(c.readings, other.readings, strict=False)
                readings = tuple(replace(a, curve=b.curve) for a, b in pairs)
                return replace(c, curve=curve, readings=readings)
            pairs = zip(c.readings, other.readings, strict=False)
            return replace(c, readings=tuple(replace(a, force_N=b.force_N) for a, b in pairs))

        return replace(_conditions(m, change), series=()), np.nan

    return make


def _stated(
    key: str, low: float, high: float, only: str = "", signs: tuple[float, ...] = (-1.0, 1.0)
) -> Callable[[Measurements, Random], Made]:
    """State another size of the sheet or the rig than it has."""

    def make(m: Measurements, random: Random) -> Made:
        factor = 1.0 + random.choice(signs) * random.uniform(low, high)

        def change(sheet: SheetGeometry) -> SheetGeometry:
            if only and sheet.configuration != only:
                return sheet
            return replace(sheet, **{key: factor * getattr(sheet, key)})

        right = next(s for n, s in m.sheets.items() if only in ("", n))
        return _sheets(m, change), float(getattr(right, key))

    return make


def _tare(m: Measurements, random: Random) -> Made:
    offset_N = float(random.choice([-1.0, 1.0]) * random.uniform(3e-3, 7e-3))
    bare = replace(m, series=())
    return _conditions(bare, lambda c: _forces(c, lambda F: F + offset_N)), offset_N


def _sign(m: Measurements, _: Random) -> Made:
    return _conditions(replace(m, series=()), lambda c: _forces(c, lambda F: -F)), -1.0


def _force_scale(factor: float) -> Callable[[Measurements, Random], Made]:
    def make(m: Measurements, _: Random) -> Made:
        bare = replace(m, series=())
        return _conditions(bare, lambda c: _forces(c, lambda F: factor * F)), 1.0 / factor

    return make


def _curve_scale(factor: float) -> Callable[[Measurements, Random], Made]:
    return lambda m, _: (
        _conditions(m, lambda c: _curves(c, _points(factor, factor, factor))),
        1.0 / factor,
    )


def _mirrored(x: float, y: float) -> Callable[[Measurements, Random], Made]:
    return lambda m, _: (_conditions(m, lambda c: _curves(c, _points(x, y, 1.0))), np.nan)


def _exchanged_axes(m: Measurements, _: Random) -> Made:
    def change(curve: Curve) -> Curve:
        return Curve(s_m=curve.s_m, x_m=curve.y_m, y_m=curve.x_m)

    return _conditions(m, lambda c: _curves(c, change)), np.nan


def _from_the_tip(m: Measurements, _: Random) -> Made:
    def change(curve: Curve) -> Curve:
        s_m = curve.s_m[-1] - curve.s_m[::-1]
        return Curve(s_m=s_m, x_m=curve.x_m[::-1].copy(), y_m=curve.y_m[::-1].copy())

    return _conditions(m, lambda c: _curves(c, change)), np.nan


def _millivolts(m: Measurements, _: Random) -> Made:
    """Half of the positions of each sheet were noted in mV."""
    places = sorted({c.position_m for c in m.conditions if c.position_m is not None})
    later = set(places[len(places) // 2 :])

    def change(c: Condition) -> Condition:
        return replace(c, voltage_V=1e3 * c.voltage_V) if c.position_m in later else c

    return replace(_conditions(m, change), series=()), 1e-3


def _wild_readings(m: Measurements, random: Random) -> Made:
    """In one of three conditions one of the readings is 60 times the noise off."""
    count = 0

    def change(c: Condition) -> Condition:
        nonlocal count
        if c.position_m is None:
            return c
        kept = [i for i, r in enumerate(c.readings) if r.kind in ("zero", "kept")]
        if len(kept) < 5 or random.uniform() > 1.0 / 3.0:
            return c
        forces = np.array([c.readings[i].force_N for i in kept])
        noise = float(np.std(forces))
        wild = int(random.choice(kept))
        count += 1

        def off(r: Reading) -> Reading:
            return replace(r, force_N=r.force_N + random.choice([-60.0, 60.0]) * noise)

        return replace(
            c, readings=tuple(off(r) if i == wild else r for i, r in enumerate(c.readings))
        )

    return _conditions(m, change), float(count)


def _swinging(m: Measurements, random: Random) -> Made:
    """Free shapes that move by about a millimetre at the tip from reading to reading."""

    def moved(r: Reading) -> Reading:
        if r.curve is None:
            return r
        s = r.curve.s_m / r.curve.s_m[-1]
        off = random.normal(0.0, 1e-3) * s**2
        return replace(r, curve=replace(r.curve, y_m=r.curve.y_m + off))

    def change(c: Condition) -> Condition:
        if c.position_m is not None:
            return c
        return replace(c, readings=tuple(moved(r) for r in c.readings))

    return _conditions(m, change), np.nan


MISTAKES = (
    Mistake("positions in metres", ("position_unit",), _positions(1e-3), 0.01),
    Mistake("positions of one sheet in metres", ("position_unit",),
            _positions(1e-3, "short"), 0.01),
    Mistake("positions 1000 times too large", ("position_unit",), _positions(1e3), 0.01),
    Mistake("order of positions reversed", ("position_order",), _reversed),
    Mistake("curves of two positions exchanged", ("exchanged_curves",),
            _two_positions(curves_alone=True)),
    Mistake("two positions exchanged", ("exchanged_curves",), _two_positions(curves_alone=False)),
    Mistake("leads exchanged at one position", ("polarity_at_position",), _leads_at_one_position),
    Mistake("polarities exchanged in the curves", ("polarity",), _polarity("curves")),
    Mistake("polarities exchanged in the forces", ("polarity",), _polarity("forces")),
    Mistake("polarities exchanged in the curves of one sheet", ("polarity",),
            _polarity("curves", "long")),
    Mistake("radius wrong by 8 to 15 %", ("arc_radius",),
            _stated("arc_radius_m", 0.08, 0.15), 0.02),
    Mistake("length wrong by 8 to 15 %", ("sheet_length",),
            _stated("free_length_m", 0.08, 0.15, "long"), 0.02),
    Mistake("elongation 8 to 15 % too long", ("sheet_length",),
            _stated("elongation_m", 0.08, 0.15, "short", (1.0,)), 0.02),
    Mistake("tare of 3 to 7 mN forgotten", ("tare",), _tare, 0.1),
    Mistake("forces with the other sign", ("force_sign",), _sign),
    Mistake("forces in N instead of mN", ("force_unit",), _force_scale(1e-3), 0.01),
    Mistake("forces 1000 times too large", ("force_unit",), _force_scale(1e3), 0.01),
    Mistake("curves in m instead of mm", ("curve_unit",), _curve_scale(1e-3), 0.02),
    Mistake("curves in pixels", ("curve_unit",), _curve_scale(2.5e4 * 1e-3), 0.02),
    Mistake("curves mirrored at the clamp's axis", ("curve_axes",), _mirrored(1.0, -1.0)),
    Mistake("curves with x backwards", ("curve_axes",), _mirrored(-1.0, 1.0)),
    Mistake("x and y exchanged", ("curve_axes",), _exchanged_axes),
    Mistake("curves from the tip to the clamp", ("curve_axes",), _from_the_tip),
    Mistake("half of the voltages in mV", ("voltage_unit",), _millivolts),
    Mistake("readings 60 sigma off", ("outlier_readings",), _wild_readings, 0.01),
    Mistake("free shapes that swing", ("swinging",), _swinging),
)  # fmt: skip
