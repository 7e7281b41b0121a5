"""The point that a model is linearised at: effects, set-ups, solutions; and a step away from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.effects.interface import BeamProblem, Effect, LoadCellInput
from model.identification.likelihood.contact_solution import Sensitivities, SolvedConditions
from model.measurements import FloatArray
from model.sheet.effect_hooks import Acting


@dataclass(frozen=True)
class AppliedEffect:
    """An effect with its values; by configuration where each has its own."""

    effect: Effect
    values: Mapping[str, Mapping[str, float]]  # configuration -> parameter -> value


def acting_in(active: Sequence[AppliedEffect], configuration: str) -> list[Acting]:
    """Return those that act in a configuration."""
    return [
        Acting(one.effect, one.values[configuration])
        for one in active
        if configuration in one.values
    ]


@dataclass(frozen=True, kw_only=True)
class Mounting:
    """How the set-up of each condition differs from the nominal one, arrays (K,)."""

    stiffness: FloatArray  # relative, of B
    eibm: FloatArray  # relative, of Me
    position_m: FloatArray
    tilt_rad: FloatArray  # of the clamp

    def applied(self, beam: BeamProblem) -> BeamProblem:
        """Return the problems of conditions that are set up so."""
        bending = (1.0 + self.eibm) / (1.0 + self.stiffness)
        return replace(
            beam, stiffness=beam.stiffness * (1.0 + self.stiffness),
            eibm=beam.eibm * bending[:, None], shift_m=beam.shift_m + self.position_m,
            tilt_rad=beam.tilt_rad + self.tilt_rad,
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class ModelState:
    """One configuration, solved."""

    # before the effects: EIBM and stiffness in the mean of each condition's readings
    base: BeamProblem
    beam: BeamProblem  # as they left it
    solved: SolvedConditions
    answers: Sensitivities
    by_eibm: FloatArray  # (K,) dF / d ln Me
    modes_by_eibm: FloatArray  # (K, M)
    response: FloatArray | None  # (K, L) force at the EIBM times `LEVELS`; None: its slope will do
    weighed: LoadCellInput  # of the readings, before what the load cell adds
    residual: FloatArray  # (N,) of this configuration's rows, at their places among all
    mounting: Mounting | None = None  # how the set-ups of the conditions differ; None: nominal

    @property
    def reach_m(self) -> FloatArray:
        """How far the EIBM moves each curve, root mean square along it: (K,)."""
        return np.asarray(np.linalg.norm(self.modes_by_eibm, axis=1))
