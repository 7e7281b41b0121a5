"""The unknown: for each place where a model can be wrong, everything smooth that could be there.

A slot is what an effect acts on. Its columns are a set of smooth shapes that share one scale; they
bend to whatever is there and pay for it in the evidence. Where a slot explains the data and no
effect of the catalogue does, something is missing that the catalogue does not know.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy.point import State, Step, Study
from model.discrepancy.score import Candidate
from model.discrepancy.settle import Fitted
from model.discrepancy.tolerance import unit
from model.effects.interface import SLOTS, Slot
from model.measurements import FloatArray

WAVES = 9
SIZES = (0.01, 0.03, 0.1, 0.3, 1.0)
UNITS: dict[Slot, str] = {
    "rest_curvature": "1/m", "eibm": "relative", "even_moment": "relative to the EIBM",
    "compliance": "relative", "position": "mm", "load_cell": "mN", "camera": "mm",
    "time": "relative",
}  # fmt: skip


@dataclass(frozen=True)
class Shape:
    """One smooth shape of a slot: its rows, and where along its coordinate it is."""

    rows: FloatArray  # (N,)
    configuration: str
    along: str  # s | position | force | time | place
    wave: Callable[[FloatArray], FloatArray] | None = None  # of a coordinate 0 .. 1
    points_m: FloatArray | None = None  # (K, S) where the camera moves points along the normal


def shapes(fitted: Fitted, slot: Slot) -> list[Shape]:
    """All smooth shapes of a slot, each at its typical size."""
    study, result = fitted.problem.study, []
    for c, state in enumerate(fitted.linear.states):
        for along, wave, step in _MAKERS[slot](study, c, state):
            rows = study.rows_of(c, state, step)
            if np.any(rows):
                points = step.points_m if slot == "camera" else None
                result.append(Shape(rows, study.names[c], along, wave, points))
    return _shared(result) if slot == "camera" else result


def unknowns(fitted: Fitted) -> list[Candidate]:
    """One candidate for each slot."""
    result = []
    for slot in SLOTS:
        found = shapes(fitted, slot)
        if found:
            columns = np.stack([s.rows for s in found], axis=1)
            result.append(Candidate(f"unknown:{slot}", {}, columns, SIZES, None, slot))
    return result


def _shared(found: list[Shape]) -> list[Shape]:
    """What the camera does, it does to both configurations."""
    names = list(dict.fromkeys(s.configuration for s in found))
    if len(names) < 2:
        return found
    columns = [[s for s in found if s.configuration == name] for name in names]
    return [
        replace(group[0], rows=np.sum([g.rows for g in group], axis=0))
        for group in zip(*columns, strict=True)
    ]


Making = Iterator[tuple[str, Callable[[FloatArray], FloatArray] | None, Step]]


def wave(j: int, size: float = 1.0) -> Callable[[FloatArray], FloatArray]:
    """A cosine of a coordinate 0 .. 1, of unit mean square; finer ones are smaller."""
    share = size / (1.0 + 0.4 * j)

    def value(t: FloatArray) -> FloatArray:
        result: FloatArray = share * (np.cos(j * np.pi * t) * (np.sqrt(2.0) if j else 1.0))
        return result

    return value


def _count(study: Study, c: int) -> int:
    return WAVES if study.scenes[c].count > 8 else 3


def _rest_curvature(study: Study, c: int, state: State) -> Making:
    yield from _along(
        study, c, lambda shape: np.repeat(5.0 * shape[None], state.beam.eibm.shape[0], 0)
    )


def _eibm(study: Study, c: int, state: State) -> Making:
    yield from _along(study, c, lambda shape: state.beam.eibm * shape, first=1)


def _even_moment(study: Study, c: int, state: State) -> Making:
    typical = float(np.mean(np.abs(state.beam.eibm[study.scenes[c].voltage_V != 0.0])))
    driven = (study.scenes[c].voltage_V != 0.0)[:, None]
    yield from _along(study, c, lambda shape: 0.3 * typical * driven * shape)


def _along(
    study: Study, c: int, moment: Callable[[FloatArray], FloatArray], first: int = 0
) -> Making:
    scene, none = study.scenes[c], study.no_step(c)
    for j in range(first, _count(study, c)):
        one = wave(j)
        beam = np.zeros_like(none.beam)
        beam[:, : scene.count] = moment(one(scene.s_m / scene.length))
        yield "s", one, replace(none, beam=beam)


def _compliance(study: Study, c: int, state: State) -> Making:
    scene, none, G = study.scenes[c], study.no_step(c), study.scenes[c].count
    total = (state.beam.eibm + state.beam.bend) * state.beam.soft
    for j in range(_count(study, c)):
        one = wave(j, 0.3)
        shape = one(scene.s_m / scene.length)
        beam = np.zeros_like(none.beam)
        beam[:, :G], beam[:, G : 2 * G] = total * shape, shape
        yield "s", one, replace(none, beam=beam)
    bent = state.solved.held.curvature - scene.rest(scene.s_m)
    for power in (1, 2):
        beam = np.zeros_like(none.beam)
        beam[:, G : 2 * G] = 0.3 * (np.abs(bent) / 30.0) ** power
        beam[:, :G] = total * beam[:, G : 2 * G]
        yield "curvature", None, replace(none, beam=beam)


def _position(study: Study, c: int, state: State) -> Making:  # noqa: ARG001
    scene, none, G = study.scenes[c], study.no_step(c), study.scenes[c].count
    R = scene.sheet.arc_radius_m
    u = unit(scene.stated_m)
    for signed in (np.ones(scene.K), np.sign(scene.voltage_V)):
        for j in range(4):
            one = wave(j, 1e-3)
            beam = np.zeros_like(none.beam)
            beam[:, 2 * G + 1] = beam[:, 2 * G + 3] = one(u) * signed / R
            yield "position", one, replace(none, beam=beam)


def _load_cell(study: Study, c: int, state: State) -> Making:
    part, none, w = study.part(c), study.no_step(c), state.weighed
    u = unit(w.position_m)
    for j in range(5):
        one = wave(j, 2e-4)
        yield "position", one, replace(none, force_N=one(u))
    scale = max(float(np.std(w.force_N)), 1e-6)
    for power in (2, 3):
        yield "force", None, replace(none, force_N=2e-4 * (w.force_N / scale) ** power / power**2)
    if np.ptp(part.clock.session) > 0.0:
        for j in range(1, 4):
            one = wave(j, 2e-4)
            yield "time", one, replace(none, force_N=one(part.clock.session))


def _camera(study: Study, c: int, state: State) -> Making:
    scene, none = study.scenes[c], study.no_step(c)
    x, y = state.solved.x_m / 0.05, (state.solved.y_m + 0.03) / 0.08
    for i in range(4):
        for j in range(4 - i):
            shape = 5e-4 * np.cos(i * np.pi * x) * np.cos(j * np.pi * y) / (1.0 + 0.5 * (i + j))
            for normal in (state.solved.nx, state.solved.ny):
                points = shape * normal * scene.has_curve[:, None]
                yield "place", None, replace(none, points_m=points)


def _time(study: Study, c: int, state: State) -> Making:  # noqa: ARG001
    part, none = study.part(c), study.no_step(c)
    driven = (part.clock.voltage_V != 0.0).astype(float)
    for name, span in (("session", 1.0), ("run_s", 20.0)):
        t = np.clip(getattr(part.clock, name) / span, 0.0, 1.0)
        if np.ptp(t) == 0.0:
            continue
        for j in range(1, 4):
            one = wave(j, 0.1)
            yield "time", one, replace(none, eibm=one(t) * driven)
            yield "time", one, replace(none, stiffness=one(t))
            if name == "run_s":
                yield "time", one, replace(none, force_N=2e-3 * one(t))
    t = np.clip(part.bin_clock.pulse_s / 0.6, 0.0, 1.0)
    for j in range(3):
        one = wave(j, 0.1)
        yield "time", one, replace(none, bin_eibm=part.bin_mean(one(t)))


_MAKERS: dict[Slot, Callable[[Study, int, State], Making]] = {
    "rest_curvature": _rest_curvature, "eibm": _eibm, "even_moment": _even_moment,
    "compliance": _compliance, "position": _position, "load_cell": _load_cell, "camera": _camera,
    "time": _time,
}  # fmt: skip
