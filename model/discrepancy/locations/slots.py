"""The unknown: for each place where a model can be wrong, everything smooth that could be there.

A location is what an effect acts on. Its columns are a set of smooth shapes that share one scale;
they bend to whatever is there and pay for it in the evidence. Where a location explains the data
and no effect of the catalogue does, something is missing that the catalogue does not know.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import legendre

from model.discrepancy.search.evidence import Candidate
from model.effects.interface import LOCATIONS, Location
from model.identification.data.periodic_terms import PHASES
from model.identification.likelihood.form_error import unit
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.identification.likelihood.model_state import ModelState, Perturbation
from model.measurements import FloatArray

WAVES = 9
EVEN, FORCE_N, LEAST_RANGE_N = 0.3, 2e-3, 1e-6
UNDER_VOLTAGE = 3  # shapes along the sheet of what is there under voltage only
TURN_RAD = 0.3  # counted in tenths, as the relative changes are
REST_PER_M, KINK_RAD, KINK_PIECE = 5.0, 5e-2, 0.02  # the last in shares of the length
SIZES = (0.01, 0.03, 0.1, 0.3, 1.0)
# units in which a location's profile is told, and what its waves count in them
UNITS: dict[Location, tuple[str, float]] = {
    "rest_curvature": ("1/m", REST_PER_M), "eibm": ("relative", 1.0),
    "even_moment": ("relative to the EIBM", EVEN), "compliance": ("relative", 1.0),
    "position": ("mm", 1e3), "load_cell": ("mN", 1e3), "camera": ("mm", 1e3),
    "time": ("relative", 1.0),
}  # fmt: skip
OWN_UNITS = {
    "force, run": ("mN", FORCE_N * 1e3),
    "age": ("relative", 1.0),
    "clamp, session": ("rad", TURN_RAD),
}  # of these parts
# parts of one shape that another part has, too: by itself what is constant costs least
ALONE = ("clamp", "zero")
# how long that takes along which a shape of time goes, with its unit
TIMES = {
    "session": (1.0, "of the session"), "run": (20.0, "s into the run"),
    "pulse": (0.6, "s into the pulse"),
    "train": (13.2, "s under voltage"),
}  # fmt: skip
Function = Callable[[FloatArray], FloatArray]  # mostly of a coordinate 0 .. 1


@dataclass(frozen=True)
class BasisShape:
    """One smooth shape of a location: its rows, and where along its coordinate it is."""

    rows: FloatArray  # (N,)
    configuration: str
    part: str  # what it changes, and along what: one of several that a location may have
    along: str  # s | position | force | time | place
    wave: Function | None = None
    points_m: FloatArray | None = None  # (K, S) where the camera moves points along the normal


@dataclass(frozen=True)
class Made:
    """A shape of one configuration before it is rows."""

    part: str
    along: str
    wave: Function | None
    step: Perturbation
    shared: bool = False  # whether the rig does it to all configurations alike


Making = Iterator[Made]


def shapes(fitted: MixedModelFit, location: Location, part: str = "") -> list[BasisShape]:
    """All smooth shapes of a location, each once, or those of a part; each at its typical size."""
    study, result = fitted.problem.study, dict[tuple[str, int, str], BasisShape]()
    for c, state in enumerate(fitted.linear.states):
        name, counts = study.names[c], dict[str, int]()
        for made in _MAKERS[location](study, c, state):
            if made.part != part if part else made.part in ALONE:
                continue
            number = counts[made.part] = counts.get(made.part, 0) + 1
            key = (made.part, number, "" if made.shared else name)
            rows = study.rows_of(c, state, made.step)
            if key in result:
                result[key] = replace(result[key], rows=result[key].rows + rows)
            else:
                points = made.step.points_m if np.any(made.step.points_m) else None
                result[key] = BasisShape(rows, name, made.part, made.along, made.wave, points)
    return [shape for shape in result.values() if np.any(shape.rows)]


def unknowns(fitted: MixedModelFit) -> list[Candidate]:
    """For each location all of its shapes, and each part of them that has a profile alone."""
    result = []
    for location in LOCATIONS:
        whole = shapes(fitted, location)
        parts = list(dict.fromkeys(s.part for s in whole if s.wave))
        several = len({s.part for s in whole}) > 1
        tried = {"": whole}
        tried |= {part: [s for s in whole if s.part == part] for part in parts if several}
        tried |= {part: shapes(fitted, location, part) for part in ALONE}
        for part, found in tried.items():
            if found:
                columns = np.stack([s.rows for s in found], axis=1)
                result.append(
                    Candidate(f"unknown:{location}", {}, columns, SIZES, None, location, part)
                )
    return result


def wave(j: int, size: float = 1.0) -> Function:
    """A cosine of a coordinate 0 .. 1, of unit mean square; finer ones are smaller."""
    share = size / (1.0 + 0.4 * j)

    def value(t: FloatArray) -> FloatArray:
        result: FloatArray = share * (np.cos(j * np.pi * t) * (np.sqrt(2.0) if j else 1.0))
        return result

    return value


def polynomial(degree: int, size: float) -> Function:
    """Legendre's, of a coordinate 0 .. 1, of unit mean square; higher ones are smaller."""
    share = size / (1.0 + 0.4 * degree)

    def value(t: FloatArray) -> FloatArray:
        number = [0.0] * degree + [np.sqrt(2.0 * degree + 1.0)]
        return np.asarray(share * legendre.legval(2.0 * t - 1.0, number))

    return value


def dying(after: float, size: float) -> Function:
    """What is large at 0 of a coordinate 0 .. 1, and `after` as much smaller as exp(1)."""

    def value(t: FloatArray) -> FloatArray:
        result: FloatArray = size * np.exp(-t / after)
        return result

    return value


def scaled(size: float, of: Function) -> Function:
    """A function, so many times."""

    def value(t: FloatArray) -> FloatArray:
        return size * of(t)

    return value


def unit_of(location: Location, part: str) -> tuple[str, float]:
    """Unit of a profile, and what its waves count in it."""
    return OWN_UNITS.get(part, UNITS[location])


def _count(study: ForwardModel, c: int) -> int:
    return WAVES if study.scenes[c].count > 8 else 3


def _rest_curvature(study: ForwardModel, c: int, state: ModelState) -> Making:
    yield from _along(
        study, c, lambda shape: np.repeat(REST_PER_M * shape[None], state.beam.eibm.shape[0], 0)
    )
    # a kink at the clamp is a rest curvature, too
    scene, none = study.scenes[c], study.no_step(c)
    beam = _clamp(study, c, np.full(scene.K, KINK_RAD))
    for part in ("s", "clamp"):
        yield Made(part, "s", _kink(scene.length), replace(none, beam=beam))


def _clamp(study: ForwardModel, c: int, angle_rad: FloatArray) -> FloatArray:
    """Step of the beam by the direction of each condition's clamp (K,): (K, Q)."""
    scene, beam = study.scenes[c], study.no_step(c).beam
    beam[:, -1] = angle_rad
    beam[:, 2 * scene.count + 1] = beam[:, 2 * scene.count + 3] = -angle_rad
    return beam


def _taken(study: ForwardModel, c: int) -> FloatArray:
    """When each condition was measured, 0 .. 1 over the session: (K,)."""
    scene, part = study.scenes[c], study.part(c)
    when = part.mean(part.clock.session)
    when[scene.free] = scene.free_clock.session
    return when


def _kink(length_m: float) -> Function:
    """The kink as the curvature of a short piece, in units of the other shapes."""
    area = 0.5 * np.sqrt(np.pi) * KINK_PIECE * length_m

    def value(t: FloatArray) -> FloatArray:
        result: FloatArray = KINK_RAD / (REST_PER_M * area) * np.exp(-((t / KINK_PIECE) ** 2))
        return result

    return value


def _eibm(study: ForwardModel, c: int, state: ModelState) -> Making:
    yield from _along(study, c, lambda shape: state.beam.eibm * shape, first=1)
    scene, none, u = study.scenes[c], study.no_step(c), _on_arc(study, c)
    for j in range(1, 5):
        one = wave(j, 0.1)
        beam = np.zeros_like(none.beam)
        beam[:, : scene.count] = one(u)[:, None] * state.beam.eibm * state.beam.soft
        yield Made("position", "position", one, replace(none, beam=beam))


def _even_moment(study: ForwardModel, c: int, state: ModelState) -> Making:
    typical = float(np.mean(np.abs(state.beam.eibm[study.scenes[c].voltage_V != 0.0])))
    driven = (study.scenes[c].voltage_V != 0.0)[:, None]
    yield from _along(study, c, lambda shape: EVEN * typical * driven * shape)


def _along(
    study: ForwardModel, c: int, moment: Callable[[FloatArray], FloatArray], first: int = 0
) -> Making:
    scene, none = study.scenes[c], study.no_step(c)
    for j in range(first, _count(study, c)):
        one = wave(j)
        beam = np.zeros_like(none.beam)
        beam[:, : scene.count] = moment(one(scene.s_m / scene.length))
        yield Made("s", "s", one, replace(none, beam=beam))


def _compliance(study: ForwardModel, c: int, state: ModelState) -> Making:
    scene, none, G = study.scenes[c], study.no_step(c), study.scenes[c].count
    total = (state.beam.eibm + state.beam.bend) * state.beam.soft
    for j in range(_count(study, c)):
        one = wave(j, 0.3)
        shape = one(scene.s_m / scene.length)
        beam = np.zeros_like(none.beam)
        beam[:, :G], beam[:, G : 2 * G] = total * shape, shape
        yield Made("s", "s", one, replace(none, beam=beam))
        if j < UNDER_VOLTAGE:
            driven = replace(none, beam=beam * (scene.voltage_V != 0.0)[:, None])
            yield Made("voltage", "s", one, driven)
    bent = state.solved.contact.curvature - scene.rest(scene.s_m)
    for power in (1, 2):
        beam = np.zeros_like(none.beam)
        beam[:, G : 2 * G] = 0.3 * (np.abs(bent) / 30.0) ** power
        beam[:, :G] = total * beam[:, G : 2 * G]
        yield Made("curvature", "curvature", None, replace(none, beam=beam))


def _position(study: ForwardModel, c: int, state: ModelState) -> Making:  # noqa: ARG001
    scene, none, G = study.scenes[c], study.no_step(c), study.scenes[c].count
    R = scene.sheet.arc_radius_m
    u = _on_arc(study, c)
    same, driven = np.ones(scene.K), np.sign(scene.voltage_V)
    # seven: one for each position of the paper; a screw's error may be anything
    for part, signed, count in (("position", same, 7), ("polarity", driven, 7), ("zero", same, 1)):
        for j in range(count):
            one = wave(j, 1e-3)
            beam = np.zeros_like(none.beam)
            beam[:, 2 * G + 1] = beam[:, 2 * G + 3] = one(u) * signed / R
            yield Made(part, "position", one, replace(none, beam=beam), shared=True)


def _on_arc(study: ForwardModel, c: int) -> FloatArray:
    """Where on the arc, 0 .. 1 over all configurations: (K,)."""
    every = unit(np.concatenate([scene.stated_m for scene in study.scenes]))
    first = sum(scene.K for scene in study.scenes[:c])
    return every[first : first + study.scenes[c].K]


def _load_cell(study: ForwardModel, c: int, state: ModelState) -> Making:
    part, none, w = study.part(c), study.no_step(c), state.weighed
    on_arc = _on_arc(study, c)[part.reading_of]
    same, driven = w.touching, w.touching * np.sign(part.clock.voltage_V)
    for name, signed, count, shared in (
        ("position", same, 7, True), ("position, each sheet", same, 5, False),
        ("polarity", driven, 3, True), ("voltage", np.abs(driven), 3, True),
        ("zero", np.ones_like(same), 1, True),
    ):  # fmt: skip
        for j in range(count):
            one = wave(j, 2e-4)
            step = replace(none, force_N=one(on_arc) * signed)
            yield Made(name, "position", one, step, shared)
    low, high = force_range_N(study)
    for degree in range(2, 6):  # in proportion to the force is what B is, too
        one = polynomial(degree, 2e-4)
        step = replace(none, force_N=one((w.force_N - low) / (high - low)) * w.touching)
        yield Made("force", "force", one, step, shared=True)
    if np.ptp(part.clock.session) > 0.0:
        for j in range(1, 9):
            one = wave(j, 2e-4)
            step = replace(none, force_N=one(part.clock.session))
            yield Made("zero, session", "time", one, step, shared=True)
    if study.wave is not None and study.wave.what == "force":
        phase = study.wave.phase(part.clock)
        for again in PHASES:
            one = scaled(FORCE_N, again)
            step = replace(none, force_N=one(phase))
            yield Made("force, period", "time", one, step, shared=True)


def force_range_N(study: ForwardModel) -> tuple[float, float]:
    """The smallest and the largest force that was measured."""
    measured = np.concatenate([part.measured_N for part in study.layout.parts])
    low, high = float(measured.min()), float(measured.max())
    return low, max(high, low + LEAST_RANGE_N)


def _camera(study: ForwardModel, c: int, state: ModelState) -> Making:
    scene, none = study.scenes[c], study.no_step(c)
    x, y = state.solved.x_m / 0.05, (state.solved.y_m + 0.03) / 0.08
    for i in range(4):
        for j in range(4 - i):
            shape = 5e-4 * np.cos(i * np.pi * x) * np.cos(j * np.pi * y) / (1.0 + 0.5 * (i + j))
            for normal in (state.solved.nx, state.solved.ny):
                points = shape * normal * scene.has_curve[:, None]
                yield Made("place", "place", None, replace(none, points_m=points), shared=True)
    # pictures of another moment: what is on its way then is half as much in the first pulse
    part = study.part(c)
    on_arc, on_its_way = _on_arc(study, c)[part.reading_of], 0.5 * (1.0 - part.clock.opposite)
    for j in range(7):  # one for each position of the paper: frames fall where they happen to
        one = wave(j, 0.1)
        step = replace(none, frame_eibm=one(on_arc) * on_its_way)
        yield Made("age", "position", one, step)


def _time(study: ForwardModel, c: int, state: ModelState) -> Making:
    part, none = study.part(c), study.no_step(c)
    at_zero = (np.nan_to_num(state.solved.force_N) - state.by_eibm)[part.reading_of]
    driven = (part.clock.voltage_V != 0.0).astype(float)
    for name, span, count in (("session", TIMES["session"][0], 8), ("run_s", TIMES["run"][0], 3)):
        t = np.clip(getattr(part.clock, name) / span, 0.0, 1.0)
        if np.ptp(t) == 0.0:
            continue
        for j in range(1, count + 1):
            one = wave(j, 0.1)
            changes = [("EIBM", replace(none, eibm=one(t) * driven)),
                       ("stiffness", replace(none, stiffness=one(t)))]  # fmt: skip
            if name == "run_s":
                changes += [("force", replace(none, force_N=FORCE_N * one(t))),
                            ("stress", replace(none, force_N=at_zero * one(t)))]  # fmt: skip
            else:
                turned = _clamp(study, c, TURN_RAD * one(_taken(study, c)))
                changes.append(("clamp", replace(none, beam=turned)))
            for what, step in changes:
                yield Made(f"{what}, {name.removesuffix('_s')}", "time", one, step, shared=True)
    t = np.clip(part.clock.driven_s / TIMES["train"][0], 0.0, 1.0)
    for pulses in (1.0, 3.0):
        one = dying(pulses / 22.0, 0.1)
        yield Made("EIBM, train", "time", one, replace(none, eibm=one(t) * driven), shared=True)
    if study.wave is not None and study.wave.what == "EIBM":
        reading, parts, sample = (
            study.wave.phase(clock) for clock in (part.clock, part.bin_clock, part.bin_sample)
        )
        for again in PHASES:
            one = scaled(0.1, again)
            within = part.bin_mean(one(parts)) - part.bin_mean(one(sample))
            step = replace(none, eibm=one(reading) * driven, bin_eibm=within)
            yield Made("EIBM, period", "time", one, step, shared=True)
    t = np.clip(part.bin_clock.pulse_s / TIMES["pulse"][0], 0.0, 1.0)
    for j in range(3):
        one = wave(j, 0.1)
        step = replace(none, bin_eibm=part.bin_mean(one(t)))
        yield Made("EIBM, pulse", "time", one, step, shared=True)


_MAKERS: dict[Location, Callable[[ForwardModel, int, ModelState], Making]] = {
    "rest_curvature": _rest_curvature, "eibm": _eibm, "even_moment": _even_moment,
    "compliance": _compliance, "position": _position, "load_cell": _load_cell, "camera": _camera,
    "time": _time,
}  # fmt: skip
