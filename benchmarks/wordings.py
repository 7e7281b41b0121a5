"""Effects of the catalogue in the words of others: whether each keeps its name.

    python -m benchmarks.wordings [TEXT ...] [--d 40] [--seed 7]

Each is hidden in a session of the world `elements`, with a law of its own in place of that world's,
at a size that is seen as d standard deviations. TEXT: only those that contain it, as `drift`.

The laws differ in what a catalogue tries by a few values (a direction, the time of a tare) or has
as one formula (how a stiffness dries). Those marked '(local)' are steps and bumps: in the worlds
such things have no name, and something unknown at the right location is right as well.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.worlds.cases import Task, made
from benchmarks.worlds.contract import World
from benchmarks.worlds.generators._elements_beam import Cases, Law, Point
from benchmarks.worlds.generators.elements import WORLD
from benchmarks.worlds.session.effects import Array, Image, Load, Sheet
from benchmarks.worlds.session.layout import Samples
from model.discrepancy import Diagnosis, diagnose

Acts = Mapping[str, Callable[..., Any]]  # the hooks of a kind, by name
Along = Callable[[Array, float], Array]  # of s and the sheet's length, m
AtSamples = Callable[[Samples], Array]
LARGER = 4.0  # than the largest size that `elements` allows: another law has other sizes


@dataclass(frozen=True, kw_only=True)
class Wording:
    """An effect and how somebody else has it."""

    effect: str
    words: str
    acts: Acts
    largest: float = 0.0  # 0: `LARGER` than that of `elements`


def main(arguments: Sequence[str] | None = None) -> None:
    """Print a line for each wording, and how many kept their names."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("text", nargs="*")
    parser.add_argument("--d", type=float, default=40.0)
    parser.add_argument("--seed", type=int, default=7)
    options = parser.parse_args(arguments)
    counted = Counter[str]()
    for one in WORDINGS:
        called = f"{one.effect}: {one.words}"
        if not options.text or any(text in called for text in options.text):
            outcome, said = asked(one, options.d, options.seed)
            counted[outcome] += 1
            print(f"{outcome:28s} {called}: {said}", flush=True)
    print(", ".join(f"{count} {outcome}" for outcome, count in counted.most_common()))


def asked(wording: Wording, d: float, seed: int) -> tuple[str, str]:
    """Return whether it kept its name, and what is said."""
    name = wording.effect
    task = Task(
        key=f"{name}: {wording.words}", world=WORLD.name, family="single", hidden=((name, d),),
        thorough=False, seed=seed,
    )  # fmt: skip
    found = diagnose(made(task, worded(wording)).session)
    names = ", ".join(f"{one.name} {one.probability:.2f}" for one in found.effects)
    unknown = "" if found.unknown is None else f" unknown: {found.unknown.location}"
    return outcome_of(found, name), f"{found.verdict} {names}{unknown}"


def outcome_of(found: Diagnosis, name: str) -> str:
    """Return how an answer has the hidden effect."""
    told = [one.name for one in found.effects]
    if told == [name] and found.unknown is None:
        return "its name alone"
    if name in found.not_ruled_out or any(name in one.probabilities for one in found.effects):
        return "its name among others"
    if found.unknown is not None:
        right = found.unknown.location in WORLD.kinds[name].locations
        return "unknown, right location" if right else "unknown, elsewhere"
    return "another name" if told else "nothing"


def worded(wording: Wording) -> World:
    """Return the world `elements` with one effect in other words."""
    own = WORLD.acts[wording.effect]
    largest = wording.largest or LARGER * own.kind.largest
    kind = replace(own.kind, largest=largest, typical=min(own.kind.typical, 0.3 * largest))
    hooks = ("cases", "setting", "law", "slides", "force", "image", "delay_s", "parameters")
    acts = {hook: wording.acts.get(hook) for hook in hooks}
    other = replace(own, kind=replace(kind, own_form=False), **acts)
    return replace(WORLD, acts={**WORLD.acts, wording.effect: other})


# ------------------------------------------------------------------------------- how a law acts


def _along(change: Callable[[Point, float, Array], None], shape: Along) -> Acts:
    def of_size(size: float) -> Law:
        def law(at: Point) -> None:
            change(at, size, shape(at.s_m, at.length_m))

        return law

    return {"law": of_size}


def _rest(at: Point, size: float, shape: Array) -> None:
    at.rest_per_m = at.rest_per_m + size * shape


def _eibm(at: Point, size: float, shape: Array) -> None:
    at.eibm_Nm = at.eibm_Nm * (1.0 + size * shape)


def _stiffness(at: Point, size: float, shape: Array) -> None:
    at.stiffness_Nm2 = at.stiffness_Nm2 * (1.0 + size * shape)


def _by_bending(shape: Callable[[Array], Array]) -> Acts:
    def of_size(size: float) -> Law:
        def law(at: Point) -> None:
            bent = (at.curvature_per_m - at.rest_per_m) / 20.0
            at.stiffness_Nm2 = at.stiffness_Nm2 * (1.0 + size * shape(bent))

        return law

    return {"law": of_size}


def _moment(course: AtSamples) -> Acts:
    def change(cases: Cases, at: Samples, _sheet: Sheet, size: float) -> None:
        cases.moment_Nm *= 1.0 + size * course(at)

    return {"cases": change}


def _stiff(course: AtSamples) -> Acts:
    def change(cases: Cases, at: Samples, _sheet: Sheet, size: float) -> None:
        cases.stiffness_Nm2 *= 1.0 + size * course(at)

    return {"cases": change}


def _placed(shape: Callable[[Array], Array]) -> Acts:
    def change(cases: Cases, _at: Samples, _sheet: Sheet, size_mm: float) -> None:
        cases.position_m += size_mm * 1e-3 * shape(cases.position_m / 30e-3)

    return {"cases": change}


def _added(shape: Callable[[Load], Array]) -> Acts:
    return {"force": lambda load, size_mN: load.force_N + size_mN * 1e-3 * shape(load)}


def _pulled(shape: Callable[[Load], Array]) -> Acts:
    return _added(lambda load: np.where(np.isnan(load.position_m), 0.0, shape(load)))


def _scaled(x: float, y: float) -> Acts:
    return {"image": lambda of, size: (of.x_m * (1.0 + x * size), of.y_m * (1.0 + y * size))}


def _tilted(degrees: float, right_at_mm: float = 0.0) -> Acts:
    cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))

    def image(of: Image, size: float) -> tuple[Array, Array]:
        away_m = of.x_m * cos + of.y_m * sin - 1e-3 * right_at_mm
        share = 1.0 + size * away_m / 50e-3
        return of.x_m * share, of.y_m * share

    return {"image": image}


def _plays(widths: Sequence[float]) -> Acts:
    def force(load: Load, size_mN: float) -> Array:
        shown = load.force_N.copy()
        for rows in load.samples.each_run():
            z = np.zeros(len(widths))
            half = 1e-3 * abs(size_mN) * np.array(widths)
            for row in rows.tolist():
                z = np.clip(z, load.force_N[row] - half, load.force_N[row] + half)
                shown[row] = np.mean(z)
        return shown

    return {"force": force}


def _dahl(load: Load, size_mN: float) -> Array:
    shown, most = load.force_N.copy(), 0.5e-3 * size_mN
    for rows in load.samples.each_run():
        held, last = 0.0, None
        for row, force in zip(rows.tolist(), load.force_N[rows].tolist(), strict=True):
            if last is not None:
                end = most * np.sign(force - last)
                held = end + (held - end) * np.exp(-abs(force - last) / 0.5e-3)
            last, shown[row] = force, force - held
    return shown


def _lagging(left: Callable[[Array, float], Array]) -> Acts:
    """Charge lags behind the voltage by what is `left` of a step after a time."""

    def rest_of(t: Array | float, tau_s: float) -> Array:
        t = np.asarray(t)
        rising = np.exp(-t / WORLD.layout.rise_s)
        return np.asarray(rising + (1.0 - rising) * left(t, tau_s))

    def change(cases: Cases, at: Samples, sheet: Sheet, tau_s: float) -> None:
        kept = float(rest_of(float(np.max(at.phase_s)), tau_s))
        slots, rows = np.unique(at.slot, return_index=True)
        begun, end = dict[int, float](), 0.0
        for slot, volts in zip(slots.tolist(), at.drive_V[rows].tolist(), strict=True):
            begun[slot], end = end, volts + (end - volts) * kept
        start = np.array([begun[slot] for slot in at.slot.tolist()])
        lagging = at.drive_V + (start - at.drive_V) * rest_of(at.phase_s, tau_s)
        cases.moment_Nm += sheet.eibm_Nm(lagging) - sheet.eibm_Nm(at.sheet_V)

    return {"cases": change}


def _slides(way: AtSamples) -> Acts:
    return {"slides": lambda s_hat, at, size: np.broadcast_to(size * way(at), np.shape(s_hat))}


def _bump(at_mm: float, width_mm: float) -> Along:
    return lambda s, _end: np.exp(-(((1e3 * s - at_mm) / width_mm) ** 2))


def _pulse(at: Samples) -> Array:
    return np.maximum(at.pulse, 0.0)


# ------------------------------------------------------------------------------- the wordings


def _all() -> Iterator[tuple[str, str, Acts] | tuple[str, str, Acts, float]]:
    name = "initial_curvature"
    yield name, "grows from the clamp", _along(_rest, lambda s, end: s / end)
    yield name, "more at one end", _along(_rest, lambda s, end: 1.0 - 2.0 * s / end)
    yield name, "bump at 25 mm (local)", _along(_rest, _bump(25.0, 8.0))
    yield name, "bump at 40 mm (local)", _along(_rest, _bump(40.0, 6.0))
    yield name, "at the clamp (local)", _along(_rest, lambda s, _end: np.exp(-s / 6e-3))
    yield name, "a whole wave (local)", _along(_rest, lambda s, end: np.sin(2.0 * np.pi * s / end))
    name = "nonuniform_eibm"
    yield name, "falls evenly", _along(_eibm, lambda s, end: 0.5 - s / end), 1.9
    yield name, "rises evenly", _along(_eibm, lambda s, end: s / end - 0.5), 1.9
    yield name, "less beyond 30 mm (local)", _along(_eibm, lambda s, _end: -1.0 * (s > 30e-3)), 0.95
    yield name, "bump at 25 mm (local)", _along(_eibm, _bump(25.0, 12.0)), 3.0
    yield name, "dead end (local)", _along(_eibm, lambda s, _end: -1.0 * (s > 42e-3)), 0.99
    yield name, "dead root (local)", _along(_eibm, lambda s, _end: -np.exp(-s / 8e-3)), 0.99
    name = "nonuniform_stiffness"
    yield name, "rises evenly", _along(_stiffness, lambda s, end: s / end - 0.5), 1.8
    yield name, "falls evenly", _along(_stiffness, lambda s, end: 0.5 - s / end), 1.8
    yield name, "more beyond 25 mm", _along(_stiffness, lambda s, _end: 1.0 * (s > 25e-3)), 3.0
    yield name, "more at the clamp", _along(_stiffness, lambda s, _end: np.exp(-s / 10e-3)), 3.0
    yield name, "bump at 25 mm (local)", _along(_stiffness, _bump(25.0, 10.0)), 3.0
    name = "nonlinear_stiffness"
    yield name, "square of the bending", _by_bending(lambda u: u**2), 1.0
    yield name, "softens", _by_bending(lambda u: -(u**2) / (1.0 + u**2)), 0.9
    yield name, "either way", _by_bending(np.abs), 1.0
    yield name, "soon over", _by_bending(lambda u: np.tanh(np.abs(u) / 0.3)), 2.0
    name = "eibm_drift"
    yield name, "evenly", _moment(lambda at: at.tau - 0.5), 0.9
    yield name, "soon over", _moment(lambda at: np.exp(-at.tau / 0.15)), 0.9
    yield name, "faster and faster", _moment(lambda at: -(at.tau**2)), 0.9
    yield name, "until 40 %", _moment(lambda at: -np.minimum(at.tau / 0.4, 1.0)), 0.9
    name = "stiffness_drift"
    yield name, "evenly", _stiff(lambda at: at.tau - 0.5), 0.9
    yield name, "softens", _stiff(lambda at: -at.tau), 0.7
    yield name, "as the root of time", _stiff(lambda at: np.sqrt(at.tau)), 1.5
    yield name, "faster and faster", _stiff(lambda at: at.tau**2), 1.5
    name = "viscoelastic_creep"
    yield name, "logarithm", _stiff(lambda at: -np.log1p(at.time_s) / 3.0), 0.7
    yield name, "exponential, 3 s", _stiff(lambda at: np.expm1(-at.time_s / 3.0)), 0.7
    yield name, "power", _stiff(lambda at: -((at.time_s / 12.0) ** 0.3)), 0.7
    name = "back_relaxation"
    yield name, "exponential, 0.15 s", _moment(lambda at: np.expm1(-at.phase_s / 0.15)), 0.9
    yield name, "evenly", _moment(lambda at: -at.phase_s / 0.6), 0.9
    late = _moment(lambda at: -np.maximum(at.phase_s - 0.25, 0.0) / 0.35)
    yield name, "from 0.25 s on", late, 0.9
    name = "first_pulse_transient"
    yield name, "the first alone", _moment(lambda at: -1.0 * (at.pulse == 0)), 0.9
    yield name, "as 1/k", _moment(lambda at: -1.0 / (1.0 + _pulse(at))), 0.9
    yield name, "exponential", _moment(lambda at: -np.exp(-_pulse(at))), 0.9
    yield name, "too large at first", _moment(lambda at: np.exp(-_pulse(at) / 2.0)), 0.9
    name = "position_error"
    yield name, "an offset", _placed(np.ones_like)
    yield name, "square of the position", _placed(np.square)
    yield name, "from the other end", _placed(lambda p: 1.0 - p)
    name = "force_drift"
    yield name, "evenly", _added(lambda load: load.samples.tau)
    yield name, "tared amid the session", _added(lambda load: load.samples.tau - 0.5)
    yield name, "tared a quarter into it", _added(lambda load: load.samples.tau - 0.25)
    yield name, "soon over", _added(lambda load: -np.expm1(-load.samples.tau / 0.1))
    yield name, "faster and faster", _added(lambda load: -(load.samples.tau**2))
    name = "load_cell_hysteresis"
    yield name, "one play", _plays([1.0])
    yield name, "four plays", _plays([0.2, 0.6, 1.2, 2.0])
    yield name, "Dahl", {"force": _dahl}
    name = "surface_tension"
    yield name, "along the normal", _pulled(lambda load: np.cos(load.lean_rad))
    yield name, "tears", _pulled(lambda load: np.exp(-((load.lean_rad / 0.2) ** 2)))
    yield name, "dries in 60 s", _pulled(lambda load: np.exp(-load.samples.wetted_s / 60.0))
    name = "camera_scale"
    yield name, "both alike", _scaled(1.0, 1.0)
    yield name, "x alone", _scaled(1.0, 0.0)
    yield name, "x longer, y shorter", _scaled(1.0, -1.0)
    name = "camera_perspective"
    for degrees in (22.0, 135.0, 157.0, -31.0):
        yield name, f"along {degrees:g} degrees", _tilted(degrees)
    yield name, "right at 25 mm along 30 degrees", _tilted(30.0, 25.0)
    yield name, "right at 40 mm along x", _tilted(0.0, 40.0)
    turned = {"force": lambda load, a: load.force_N * np.cos(a) + load.outward_N * np.sin(a)}
    yield "load_cell_misalignment", "the other way", turned
    name = "charging_lag"
    yield name, "one exponential", _lagging(lambda t, tau: np.exp(-t / tau))
    yield name, "as the root of time", _lagging(lambda t, tau: 1.0 / (1.0 + np.sqrt(t / tau))), 0.4
    yield name, "stretched", _lagging(lambda t, tau: np.exp(-((t / tau) ** 0.6)))
    name = "roll_friction"
    yield name, "one way", _slides(lambda at: np.ones_like(at.tau)), 0.8
    yield name, "by the voltage", _slides(lambda at: np.sign(at.drive_V)), 0.8


WORDINGS = [
    Wording(effect=effect, words=words, acts=acts, largest=more[0] if more else 0.0)
    for effect, words, acts, *more in _all()
]

if __name__ == "__main__":
    main()
