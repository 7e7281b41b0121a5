"""What a course in time does to pictures: late ones, and free shapes, which have no readings."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from model.effects.interface import BeamProblem, Effect, Values
from model.measurements import FloatArray

if TYPE_CHECKING:
    from model.identification.likelihood.forward_model import ForwardModel, ModelState


def pictured(
    study: ForwardModel, c: int, inner: list[tuple[Effect, Values]]
) -> tuple[FloatArray, FloatArray] | None:
    """Relative change of the EIBM in pictures: of readings (n,), of free shapes (K,)."""
    clock, free = study.part(c).clock, study.scenes[c].free_clock
    found = [(e.pictured(clock, v), e.pictured(free, v)) for e, v in inner]
    seen = [(one, other) for one, other in found if one is not None and other is not None]
    if not seen:
        return None
    readings, shapes = (np.sum(both, axis=0) for both in zip(*seen, strict=True))
    return readings, _of_free(study, c, shapes)


def free_course(study: ForwardModel, c: int, effect: Effect, values: Values) -> FloatArray:
    """Relative change of Me/B that a course in time makes to the free shapes: (K,)."""
    course = effect.course(study.scenes[c].free_clock, values)
    if course is None:
        return np.zeros(study.scenes[c].K)
    return _of_free(study, c, course[0] - course[1])


def _of_free(study: ForwardModel, c: int, values: FloatArray) -> FloatArray:
    """Values of the free shapes among all conditions; 0 elsewhere and at 0 V: (K,)."""
    scene, result = study.scenes[c], np.zeros(study.scenes[c].K)
    result[scene.free] = np.where(scene.voltage_V[scene.free] != 0.0, values, 0.0)
    return result


def bent(study: ForwardModel, c: int, state: ModelState, change: FloatArray) -> FloatArray:
    """Step of the beam by a relative change of the EIBM of each condition (K,): (K, Q)."""
    step = study.no_step(c).beam
    pushed = state.beam.eibm * state.beam.soft
    step[:, : study.scenes[c].count] = change[:, None] * pushed
    return step


def modes_in_pictures(
    study: ForwardModel, c: int, beam: BeamProblem, seen: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """Modes of the distances of the curves in late pictures, exactly: (K, M).

    `seen` is what `pictured` says of them.
    """
    change = study.part(c).mean(seen[0]) + seen[1]
    return study.scenes[c].modes_of(replace(beam, eibm=beam.eibm * (1.0 + change[:, None])))
