"""The point that a model is linearised at: effects, set-ups, solutions; and a step away from it.

A `Found` effect has values that are refined, and ways in which its form differs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from model.effects.interface import BeamProblem, Effect, EffectParameter, LoadCellInput
from model.identification.likelihood.contact_solution import Sensitivities, SolvedConditions
from model.measurements import FloatArray
from model.sheet.beam_problem import Profile
from model.sheet.effect_hooks import Acting
from model.sheet.form import Form, combined, form_in, scaled
from model.sheet.free_effect import acting_with

MOST_LOG_STEP = 0.4
NEAR = 0.3  # of a standard uncertainty: two places are the same


@dataclass(frozen=True)
class AppliedEffect:
    """An effect with its values; by configuration where each has its own."""

    effect: Effect
    values: Mapping[str, Mapping[str, float]]  # configuration -> parameter -> value
    # configuration -> form; without: the catalogue's
    forms: Mapping[str, Form] = field(default_factory=dict)


def acting_in(active: Sequence[AppliedEffect], configuration: str) -> list[Acting]:
    """Return those that act in a configuration."""
    return [
        acting_with(one.effect, one.values[configuration], one.forms.get(configuration))
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

    @cached_property
    def by_stiffness(self) -> FloatArray:
        """Return dF / d ln B at the same k* (K,); where there is no force, that of none."""
        return np.nan_to_num(self.solved.force_N) - self.by_eibm

    @cached_property
    def reach_m(self) -> FloatArray:
        """How far the EIBM moves each curve, root mean square along it: (K,)."""
        return np.asarray(np.linalg.norm(self.modes_by_eibm, axis=1))


# -- effects that are found


@dataclass(frozen=True, kw_only=True)
class FormWay:
    """A way in which the form of an effect differs, in all configurations that have it."""

    terms: tuple[Profile, ...]  # for a size of one
    size: float
    sigma: float  # of the prior of the size, about 0


@dataclass(frozen=True, kw_only=True)
class Found:
    """An effect in the model, with the values it has there."""

    effect: Effect
    values: Mapping[str, Mapping[str, float]]  # configuration -> parameter -> value
    width: float = 3.0  # of the prior of the size, in units of its plausible size
    sigma: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    given: tuple[Profile, ...] | None = None  # the form that it is known to have; None: not known
    ways: tuple[FormWay, ...] = ()  # in which its form is inferred to differ; states have them
    form: float = 1.0  # how much of the tolerance of its form there is

    @property
    def active(self) -> AppliedEffect:
        """As states have it."""
        terms = self.terms
        forms = {name: form_in(terms, name) for name in self.values} if terms else {}
        return AppliedEffect(
            self.effect, self.values, {name: form for name, form in forms.items() if form}
        )

    @property
    def terms(self) -> tuple[Profile, ...]:
        """The terms of its form, as a model has them."""
        own = [scaled(term, way.size) for way in self.ways for term in way.terms]
        return combined((*(self.given or ()), *own))

    def parameters(self) -> list[tuple[EffectParameter, tuple[str, ...]]]:
        """Knobs that are refined, each with the configurations that share its value."""
        names = tuple(self.values)
        free = [k for i, k in enumerate(self.effect.parameters) if i == 0 or k.log or k.estimated]
        if not self.effect.by_configuration:
            return [(k, names) for k in free]
        return [(k, (name,)) for k in free for name in names]


def prior_of(parameter: EffectParameter, value: float, one: Found) -> tuple[float, float]:
    """Width of a parameter's prior, and how far its value is from the middle."""
    if not parameter.log:
        return one.width * parameter.prior_scale, value - parameter.neutral
    if parameter is not one.effect.amplitude:
        return 1.0, 0.0
    if np.isfinite(parameter.neutral) and parameter.neutral > 0.0:
        usual = abs(float(np.log(parameter.prior_scale / parameter.neutral)))
        return one.width * usual, float(np.log(value / parameter.neutral))
    return 1.0, float(np.log(value / parameter.prior_scale))


def moved(
    found: tuple[Found, ...], beta: FloatArray, sigma: FloatArray, spans: list[slice]
) -> tuple[tuple[Found, ...], float]:
    """Return the effects after a step, and the largest change of a parameter in its sigmas."""
    result, largest = [], 0.0
    for one, span in zip(found, spans, strict=True):
        values = {name: dict(v) for name, v in one.values.items()}
        unsure = {name: dict(one.sigma.get(name, {})) for name in values}
        for place, (parameter, names) in enumerate(one.parameters(), span.start):
            step, doubt = float(beta[place]), float(sigma[place])
            largest = max(largest, abs(step) / max(doubt, 1e-300))
            for name in names:
                old = values[name][parameter.name]
                if parameter.log:
                    new = old * float(np.exp(np.clip(step, -MOST_LOG_STEP, MOST_LOG_STEP)))
                    unsure[name][parameter.name] = new * doubt
                else:
                    most = max(3.0 * abs(parameter.prior_scale), abs(old - parameter.neutral))
                    new = old + float(np.clip(step, -most, most))
                    unsure[name][parameter.name] = doubt
                values[name][parameter.name] = float(np.clip(new, parameter.low, parameter.high))
        first = span.start + len(one.parameters())
        steps = beta[first : first + len(one.ways)].tolist()
        ways = tuple(
            replace(way, size=way.size + step) for way, step in zip(one.ways, steps, strict=True)
        )
        result.append(replace(one, values=values, sigma=unsure, ways=ways))
    return tuple(result), largest


@dataclass(frozen=True, kw_only=True)
class FitPlace:
    """Where a fit has come to: parameters, effects, and the noise on the way there."""

    theta: FloatArray
    found: tuple[Found, ...]
    log_sigma: FloatArray

    def near(self, other: FitPlace, sigma: FloatArray) -> bool:
        """Return whether another place is the same but for a part of the uncertainties.

        `sigma` is that of the base parameters; effects of no stated uncertainty must be equal.
        """
        if np.any(np.abs(self.theta - other.theta) > NEAR * sigma[: len(self.theta)]):
            return False
        for one, two in zip(self.found, other.found, strict=True):
            for name, values in one.values.items():
                unsure = one.sigma.get(name, {})
                for key, value in values.items():
                    if abs(value - two.values[name][key]) > NEAR * unsure.get(key, 0.0):
                        return False
        return True
