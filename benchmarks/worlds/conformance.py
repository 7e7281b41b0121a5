"""What is wrong with a generator: `faults(name)` is empty for one that keeps the contract.

The physics is held against the equations themselves, not against another solver: free strips have
the stated curvature plus that of a constant EIBM; held ones satisfy k = k0 + (Me + M)/B with one B
for all positions; the short sheet is a cantilever with a rigid lever.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from benchmarks.worlds.contract import LOCATIONS, Design, World
from benchmarks.worlds.registry import files, world
from model.effects.catalogue import catalogue
from model.measurements import Condition, FloatArray, Measurements, SheetGeometry

SEED = 11
FEW = Design(positions_m={"long": (0.0, 0.02), "short": (0.0, 0.02)}, readings=3)
FINE = replace(FEW, curve_points=201, readings=1, series=False)
TINY = 1e-9  # of a typical size
ARC_M, ONE_B, CANTILEVER, PLACE_M = 2e-6, 0.004, 0.04, 3e-6
SAME_N, SAME_M = 1e-7, 1e-8
ROUNDING = 1e-12  # N or m: sums of the same numbers at another place in memory
Fault = Iterator[str]


def faults(name: str) -> list[str]:
    """Return a sentence for each fault."""
    one = world(name)
    found = [fault for check in CHECKS.values() for fault in check(one)]
    return [*imports(name), *found]


# --------------------------------------------------------------------------------- the file


def imports(name: str) -> list[str]:
    """Return what a generator imports although it may not."""
    result = []
    for path in files(name):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            wanted = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            if isinstance(node, ast.ImportFrom):
                wanted = [f"{node.module}.{a.name}" for a in node.names]
            if isinstance(node, ast.Import):
                wanted = [a.name for a in node.names]
            result += [f"{path.name} imports {w}" for w in wanted if not _allowed(w, name)]
    return result


OFFERED = "benchmarks.worlds.contract", "benchmarks.worlds.session"


def _allowed(module: str, name: str) -> bool:
    first = module.split(".", maxsplit=1)[0]
    if first == "model":
        return module.startswith("model.measurements.") or module == "model.measurements"
    own = f"benchmarks.worlds.generators._{name}_", f"benchmarks.worlds.generators.{name}"
    if first == "benchmarks":
        return module.startswith((*OFFERED, *own))
    if first == "sim_hardware":
        return module.startswith("sim_hardware.world.motion.")
    return first not in ("labrig", "drivers", "protocols", "tests")


def described(one: World) -> Fault:
    """Kinds and what is told of them."""
    known = catalogue()
    if not one.name or not one.numerics or not one.noise or not one.kinds:
        yield "name, numerics, noise or kinds are missing"
    for name, kind in one.kinds.items():
        if not 0.0 < kind.typical <= kind.largest:
            yield f"{name}: not 0 < typical <= largest"
        if not kind.locations or set(kind.locations) - set(LOCATIONS):
            yield f"{name}: locations {kind.locations} are not those of the contract"
        if set(kind.needs) - {"series", "free_shapes"}:
            yield f"{name}: nobody knows what it needs: {kind.needs}"
        if kind.known_as is not None and kind.known_as not in known:
            yield f"{name}: the catalogue has no {kind.known_as}"
            continue
        told = one.parameters(name, kind.typical)
        own = {} if kind.known_as is None else {p.name for p in known[kind.known_as].parameters}
        if bool(told) != kind.own_form or set(told) - set(own):
            yield f"{name}: parameters {dict(told)} do not fit own_form = {kind.own_form}"


# ------------------------------------------------------------------------ seeds, sizes, designs


def repeatable(one: World) -> Fault:
    """The same seed gives the same session, another one another."""
    first, again = (one.measure(FEW, {}, SEED) for _ in range(2))
    if max(_away(first, again)) > ROUNDING:
        yield "the same seed gives another session"
    if _away(first, one.measure(FEW, {}, SEED + 1))[0] < SAME_N:
        yield "another seed gives the same session"


def same_noise(one: World) -> Fault:
    """Whatever is hidden, noise and set-ups stay; a size does something, and none does nothing."""
    bare = one.measure(FEW, {}, SEED)
    for name, kind in one.kinds.items():
        if max(_away(bare, one.measure(FEW, {name: 0.0}, SEED))) > ROUNDING:
            yield f"{name}: of no size, and yet something changes"
        force, curve = _away(bare, one.measure(FEW, {name: TINY * kind.typical}, SEED))
        if force > SAME_N or curve > SAME_M:
            yield f"{name}: with next to nothing hidden the noise is another one ({force:.1e} N)"
        force, curve = _away(bare, one.measure(FEW, {name: kind.typical}, SEED))
        if not (np.isfinite(force) and np.isfinite(curve)) or force + curve == 0.0:
            yield f"{name}: of a typical size it changes nothing"


def refuses(one: World) -> Fault:
    """`ValueError` for what it does not have."""
    name, kind = next(iter(one.kinds.items()))
    for wrong in ({"no such kind": 1.0}, {name: 1.01 * kind.largest}, {name: float("nan")}):
        try:
            one.measure(FEW, wrong, SEED)
        except ValueError:
            continue
        yield f"no ValueError for {wrong}"


def designed(one: World) -> Fault:
    """Sessions hold what the design asks for."""
    design = replace(FEW, free_shapes=1, remounts=2, random_order=True, curve_points=17)
    found = one.measure(design, {}, SEED)
    wanted = sorted((c, p, m) for c in ("long", "short") for p in (0.0, 0.02) for m in (0, 1))
    held = [c for c in found.conditions if c.position_m is not None]
    for volts in (0.0, *design.voltages_V):
        got = sorted(
            (c.configuration, c.position_m, c.mounting) for c in held if c.voltage_V == volts
        )
        if got != wanted:
            yield f"conditions at {volts:g} V are {got}, not {wanted}"
    if any(len(c.used()) != design.readings for c in held):
        yield f"not {design.readings} readings of each voltage"
    driven = [c for c in held if c.voltage_V != 0.0]
    thrown = sum(r.kind == "discarded" for c in driven for r in c.readings)
    if thrown != len(driven) // 2 * design.discarded:
        yield f"{thrown} readings are discarded"
    free = [c for c in found.conditions if c.position_m is None]
    if len(free) != 2 * 3 or any(c.curve is None for c in free):
        yield f"{len(free)} free conditions, not one at each voltage, or without a curve"
    if any(c.curve is None or len(c.curve.s_m) != 17 for c in found.conditions):
        yield "curves do not have the wanted number of points"
    times = [r.session_s for c in held for r in c.readings]
    if any(t is None for t in times) or len(set(times)) != len(times):
        yield "readings have no times, or share them"
    yield from _streams(one, found)


def _streams(one: World, found: Measurements) -> Fault:
    if not found.series or any(r.curve is None for c in found.conditions for r in c.readings):
        yield "no series, or readings without curves"
    without = one.measure(replace(FEW, series=False), {}, SEED)
    if without.series or any(r.curve is not None for c in without.conditions for r in c.readings):
        yield "series or curves of readings although none are wanted"


def noiseless(one: World) -> Fault:
    """`exact` leaves no noise: readings of a condition are the same."""
    found = one.measure(FEW, {}, SEED, exact=True)
    for c in found.conditions:
        spread = float(np.ptp([r.force_N for r in c.used()]))
        if spread > SAME_N:
            yield f"{_called(c)}: exact, and yet readings are {spread:.1e} N apart"
    # a position without noise does not depend on the others that are measured
    alone = one.measure(replace(FEW, positions_m={"long": (0.02,)}), {}, SEED, exact=True)
    both = [c for c in found.conditions if c.configuration == "long" and c.position_m == 0.02]
    for a, b in zip(alone.conditions, both, strict=True):
        if abs(_mean(a) - _mean(b)) > SAME_N:
            yield f"{_called(a)}: exact, and yet it depends on what else is measured"


# ------------------------------------------------------------------------------------- physics


def arcs(one: World) -> Fault:
    """Free strips: the stated curvature, and under a voltage the same amount more everywhere."""
    found = one.measure(replace(FINE, free_shapes=1), {}, SEED, exact=True)
    for c in found.conditions:
        if c.position_m is None:
            sheet = found.sheets[c.configuration]
            away = _from_arc(c, sheet)
            if away > ARC_M:
                yield f"{_called(c)}: free, {away * 1e6:.1f} um from what a constant EIBM bends"


def _from_arc(c: Condition, sheet: SheetGeometry) -> float:
    """Return the largest distance from the nearest shape with a constant curvature added."""
    assert c.curve is not None
    measured = np.stack([c.curve.x_m, c.curve.y_m])
    added, step = 0.0, 1e-3
    for _ in range(4 if c.voltage_V else 0):
        here, there = (_shape(sheet, c.curve.s_m, k) for k in (added, added + step))
        slope = (there - here) / step
        added += float(np.sum(slope * (measured - here)) / np.sum(slope**2))
    return float(np.max(np.abs(measured - _shape(sheet, c.curve.s_m, added))))


def _shape(sheet: SheetGeometry, s_m: FloatArray, added_per_m: float) -> FloatArray:
    """Return the free shape (2, n), its curvature integrated in 20 000 steps."""
    nodes, k0 = sheet.initial_curvature or (np.zeros(1), np.zeros(1))
    edges = np.linspace(0.0, float(s_m[-1]), 20_001)
    middle, step = 0.5 * (edges[1:] + edges[:-1]), edges[1]
    k = np.where(middle < sheet.free_length_m, np.interp(middle, nodes, k0) + added_per_m, 0.0)
    phi = np.cumsum(k) * step - 0.5 * k * step
    upto = [np.concatenate([[0.0], np.cumsum(f(phi)) * step]) for f in (np.cos, np.sin)]
    return np.stack([np.interp(s_m, edges, v) for v in upto])


def one_stiffness(one: World) -> Fault:
    """Held strips: k - k0 = (Me + M)/B with the force that is shown, and one B for all."""
    found = one.measure(FINE, {}, SEED, exact=True)
    for name, sheet in found.sheets.items():
        held = [c for c in found.conditions if c.configuration == name]
        B = [b for c in held if abs(_mean(c)) > 2e-4 and (b := _stiffness(c, sheet)) is not None]
        if len(B) < 3:
            yield f"{name}: too few conditions with a force"
        elif np.ptp(B) > ONE_B * np.mean(B) or min(B) <= 0.0:
            yield f"{name}: force and shape want B from {min(B):.3e} to {max(B):.3e} N m^2"


def _stiffness(c: Condition, sheet: SheetGeometry) -> float | None:
    """Return B from the shape between clamp and contact, and the force along the arc."""
    assert c.curve is not None
    at = _contact(c, sheet)
    if at is None:
        return None
    s, x, y = (np.asarray(v) for v in (c.curve.s_m, c.curve.x_m, c.curve.y_m))
    end = min(at, sheet.free_length_m)
    inside = s <= end + 1e-9  # a spline over the strip alone: the elongation has no curvature
    path = CubicSpline(s[inside], np.stack([x[inside], y[inside]], axis=1))
    whole = CubicSpline(s, np.stack([x, y], axis=1))
    nodes, k0 = sheet.initial_curvature or (np.zeros(1), np.zeros(1))
    use = np.linspace(0.1, 0.9, 60) * end
    (tx, ty), (ax, ay) = path(use, 1).T, path(use, 2).T
    k = tx * ay - ty * ax
    touch, along = whole(at), whole(at, 1)
    along = along / np.linalg.norm(along)
    lever = (touch - path(use)) @ along
    columns = np.stack([np.ones(len(use)), -lever], axis=1)
    _, nu = np.linalg.lstsq(columns, k - np.interp(use, nodes, k0), rcond=None)[0]
    beta = (c.position_m or 0.0) / sheet.arc_radius_m
    cosine = float(along @ (np.cos(beta), np.sin(beta)))
    return _mean(c) / (float(nu) * cosine)


def _contact(c: Condition, sheet: SheetGeometry) -> float | None:
    """Return where along the curve it first crosses the arc; None: it does not."""
    assert c.curve is not None
    far = np.hypot(c.curve.x_m, c.curve.y_m) - sheet.arc_radius_m
    beyond = np.flatnonzero(far >= -1e-9)
    if not len(beyond):
        return None
    spline = CubicSpline(c.curve.s_m, far)
    roots = spline.roots(extrapolate=False)
    near = roots[np.abs(roots - c.curve.s_m[beyond[0]]) < 2 * c.curve.s_m[1]]
    return float(near[0]) if len(near) else float(c.curve.s_m[beyond[0]])


def placed(one: World) -> Fault:
    """The curve crosses the arc where the cell stands."""
    found = one.measure(FINE, {}, SEED, exact=True)
    for c in found.conditions:
        sheet = found.sheets[c.configuration]
        at = _contact(c, sheet)
        if at is None or c.curve is None:
            yield f"{_called(c)}: the curve does not reach the arc"
            continue
        x, y = CubicSpline(c.curve.s_m, np.stack([c.curve.x_m, c.curve.y_m], axis=1))(at)
        away = sheet.arc_radius_m * np.arctan2(y, x) - (c.position_m or 0.0)
        if abs(away) > PLACE_M:
            yield f"{_called(c)}: the curve is {away * 1e6:.1f} um from the cell"


def cantilever(one: World) -> Fault:
    """The short sheet, bent little: F = -3 B (p - p_free)/(R^3 - (R - l)^3)."""
    fine = replace(FINE, positions_m={"short": (0.0, 0.002, 0.004, 0.006)})
    found = one.measure(fine, {}, SEED, exact=True)
    sheet, held = found.sheets["short"], [c for c in found.conditions if c.voltage_V == 0.0]
    R, lever_m = sheet.arc_radius_m, sheet.arc_radius_m - sheet.free_length_m
    B = [b for c in held if (b := _stiffness(c, sheet)) is not None]
    slope = np.polyfit([c.position_m or 0.0 for c in held], [_mean(c) for c in held], 1)[0]
    wanted = -3.0 * abs(float(np.median(B))) / (R**3 - lever_m**3)
    if abs(slope / wanted - 1.0) > CANTILEVER:
        yield f"the short sheet's force falls by {slope:.4f} N/m, a cantilever's by {wanted:.4f}"


def resisting(one: World) -> Fault:
    """Friction holds back what the voltages do: it brings their forces nearer to each other."""
    rubbing = {n: kind for n, kind in one.kinds.items() if kind.known_as == "roll_friction"}
    bare = _swing_N(one, {}) if rubbing else 0.0
    for name, kind in rubbing.items():
        if (more := _swing_N(one, {name: kind.typical}) - bare) > SAME_N:
            yield (
                f"{name}: forces at both voltages are {more:.1e} N farther apart than without it:"
                " friction that pushes"
            )


def _swing_N(one: World, hidden: Mapping[str, float]) -> float:
    """Return how far apart the forces of both voltages are, summed over the positions."""
    found = one.measure(FEW, hidden, SEED, exact=True)
    return sum(
        float(np.sign(c.voltage_V)) * _mean(c)
        for c in found.conditions
        if c.position_m is not None
    )  # fmt: skip


CHECKS: dict[str, Callable[[World], Fault]] = {
    check.__name__: check
    for check in (
        described, repeatable, same_noise, refuses, designed, noiseless, arcs, one_stiffness,
        placed, cantilever, resisting,
    )
}  # fmt: skip


# ------------------------------------------------------------------------------------- details


def _mean(c: Condition) -> float:
    return float(np.mean([r.force_N for r in c.used()]))


def _called(c: Condition) -> str:
    place = "free" if c.position_m is None else f"{c.position_m * 1e3:g} mm"
    return f"{c.configuration}, {place}, {c.voltage_V:+g} V"


def _away(first: Measurements, second: Measurements) -> tuple[float, float]:
    """Return the largest difference of readings and series (N) and of curves (m)."""
    force, curve = [0.0], [0.0]
    for a, b in zip(first.conditions, second.conditions, strict=True):
        pairs = [(a.curve, b.curve)]
        for r, q in zip(a.readings, b.readings, strict=True):
            force.append(abs(r.force_N - q.force_N))
            pairs.append((r.curve, q.curve))
        for c, d in pairs:
            if c is not None and d is not None:
                curve.append(float(np.max(np.abs([c.x_m - d.x_m, c.y_m - d.y_m]))))
    for s, t in zip(first.series, second.series, strict=True):
        if s.force_N is not None and t.force_N is not None:
            force.append(float(np.max(np.abs(s.force_N - t.force_N))))
    return max(force), max(curve)
