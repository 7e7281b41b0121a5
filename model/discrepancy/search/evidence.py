"""Compute each candidate's evidence from the residual of the present model.

A candidate is a set of columns: its form, and the ways in which the form may differ, with a common
scale. The scale is integrated over a range of sizes, so that a candidate pays for being flexible
(Bayes factor by Laplace, exact here since all is Gaussian).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from model.discrepancy.thresholds import BOUNDS_FACTOR, FURTHER_NAME_LN, UNEXPECTED_SIGN_LN
from model.effects.catalogue import origins
from model.effects.interface import Effect, EffectParameter, Values
from model.identification.foreign_parts import answers_of
from model.identification.likelihood.form_ways import atoms
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.linearisation import Linearisation
from model.identification.likelihood.mixed_model import Solution, estimate
from model.identification.likelihood.mixed_model_fit import MixedModelFit, prior_terms
from model.identification.likelihood.model_state import ModelState
from model.measurements import FloatArray

SIZES = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)  # in units of the plausible size
TOGETHER = 20  # candidates whose columns are multiplied at once
FULL = (0.05, 0.1, 0.2, 0.5, 1.0, 1.5)  # where a tried value is the whole effect


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """An effect with one choice of its shape, as columns (N, 1 + J)."""

    name: str
    values: Mapping[str, float]
    columns: FloatArray
    sizes: tuple[float, ...]
    effect: Effect | None = None
    location: str = ""
    part: str = ""  # of the location; empty: all of it


@dataclass(frozen=True, kw_only=True)
class Score:
    """The evidence of a candidate at a solution."""

    candidate: Candidate
    log_bayes: float
    amplitude: float  # most likely multiple of the candidate's own size
    scale: float  # the size at which the evidence is largest
    length: float  # whitened length of the form at unit size, after the base is refitted
    further: tuple[float, ...] = ()  # most likely multiples of further sizes


def members(effect: Effect) -> list[dict[str, float]]:
    """Return values to try: each shape, at the plausible size."""
    result: list[dict[str, float]] = [{}]
    for i, parameter in enumerate(effect.parameters):
        # one that is refined in its logarithm has its plausible value, others a plausible step
        offset = 0.0 if parameter.log or i else parameter.neutral
        usual = offset + parameter.prior_scale
        tried = parameter.starting_values or (usual,)
        result = [{**r, parameter.name: v} for r in result for v in tried]
    return result


def candidates(
    fitted: MixedModelFit, effects: Sequence[Effect], *, tolerant: bool = True
) -> list[Candidate]:
    """Return every effect in each of its shapes, as columns at the present model.

    Not `tolerant`: its form alone, without the ways in which it may differ. Those of an effect are
    computed once at the same states.
    """
    forward, kept = fitted.problem.forward, fitted.linear.at_states
    dated = any(
        np.ptp(block.clock.session) > 0.0
        for block in forward.row_index.blocks
        if len(block.clock.session)
    )
    foreign = origins()
    result = []
    for effect in effects:
        if effect.needs_session and not dated:
            continue
        key = (id(forward), effect.name, tolerant)
        of, found = kept.get(key, (None, []))
        if of is not effect:
            shapes = partial(_shapes, fitted, effect, tolerant=tolerant)
            if effect.name in foreign:
                whose = f"the effect '{effect.name}' of {foreign[effect.name]}"
                ask = partial(_finite, shapes)
                found = answers_of(whose, Candidate, ask, "the search goes on") or []
            else:
                found = shapes()
            kept[key] = (effect, found)
        result += found
    return result


def _shapes(fitted: MixedModelFit, effect: Effect, *, tolerant: bool) -> list[Candidate]:
    """Return an effect in each of its shapes."""
    return [_candidate(fitted, effect, values, tolerant=tolerant) for values in members(effect)]


def _finite(shapes: Callable[[], list[Candidate]]) -> list[Candidate]:
    """Return them; raise ValueError where one is not finite."""
    found = shapes()
    if not all(np.isfinite(one.columns).all() for one in found):
        raise ValueError("what it changes is not a finite number everywhere")
    return found


def _candidate(
    fitted: MixedModelFit, effect: Effect, values: Values, *, tolerant: bool
) -> Candidate:
    """Return an effect in one shape, as columns at the present model."""
    forward, states = fitted.problem.forward, fitted.linear.states
    steps = [forward.step(c, states[c], effect, values) for c in range(len(states))]
    further = [_further(forward, states, effect, k) for k in effect.parameters if k.estimated]
    columns = np.concatenate(
        [atoms(forward, states, effect, steps, tolerant=tolerant), *further], axis=1
    )
    return Candidate(
        name=effect.name,
        values=values,
        columns=columns,
        sizes=FULL if effect.amplitude.starting_values else SIZES,
        effect=effect,
        location=effect.location,
    )


def _further(
    forward: ForwardModel, states: Sequence[ModelState], effect: Effect, size: EffectParameter
) -> FloatArray:
    """Return the columns of a further size, the first one absent: (N, 1); (N, C) of each sheet."""
    values = {k.name: k.neutral for k in effect.parameters} | {size.name: size.prior_scale}
    steps = [forward.step(c, state, effect, values) for c, state in enumerate(states)]
    rows = [forward.rows_of(c, states[c], step) for c, step in enumerate(steps)]
    return np.stack(rows if effect.by_configuration else [np.sum(rows, axis=0)], axis=1)


@dataclass(frozen=True)
class Projected:
    """Weights, with the present model's columns projected out."""

    weights: FloatArray  # (R, n, n)
    WX: FloatArray  # (N, p) by rows
    covariance: FloatArray
    pulled: FloatArray  # (N,) P y

    @staticmethod
    def of(forward: ForwardModel, linear: Linearisation, solution: Solution) -> Projected:
        """At a solution."""
        row_index, data = forward.row_index, linear.data
        WX = (solution.weights @ data.X)[row_index.run_of, row_index.row_of]
        error = data.y - data.X @ solution.beta
        We = (solution.weights @ error[:, :, None])[:, :, 0]
        return Projected(
            solution.weights, WX, solution.covariance, We[row_index.run_of, row_index.row_of]
        )

    def normal(self, forward: ForwardModel, S: FloatArray) -> tuple[FloatArray, FloatArray]:
        """S'PS and S'Py."""
        (found,) = self.normals(forward, [S])
        return found

    def normals(
        self, forward: ForwardModel, some: Sequence[FloatArray]
    ) -> list[tuple[FloatArray, FloatArray]]:
        """Return the same of several; what they have in common is one product."""
        row_index, S = forward.row_index, np.concatenate(some, axis=1)
        WS = (self.weights @ row_index.pad(S))[row_index.run_of, row_index.row_of]
        XS, Sy = self.WX.T @ S, S.T @ self.pulled
        known = self.covariance @ XS
        ends = np.cumsum([one.shape[1] for one in some]).tolist()
        parts = [slice(end - one.shape[1], end) for end, one in zip(ends, some, strict=True)]
        return [(S[:, own].T @ WS[:, own] - XS[:, own].T @ known[:, own], Sy[own]) for own in parts]


def score(forward: ForwardModel, projected: Projected, candidate: Candidate) -> Score:
    """Return evidence of a candidate at given noise."""
    return scored(forward, projected, [candidate])[0]


def scored(forward: ForwardModel, projected: Projected, pool: Sequence[Candidate]) -> list[Score]:
    """Return evidence of candidates at given noise."""
    result = list[Score]()
    for first in range(0, len(pool), TOGETHER):
        some = pool[first : first + TOGETHER]
        found = projected.normals(forward, [one.columns for one in some])
        result += [_score(one, A, b) for one, (A, b) in zip(some, found, strict=True)]
    return result


def _score(candidate: Candidate, A: FloatArray, b: FloatArray) -> Score:
    D, U = np.linalg.eigh(0.5 * (A + A.T))
    D = np.maximum(D, 0.0)
    z = U.T @ b
    scales = np.array(candidate.sizes)
    v = scales[:, None] ** 2
    gains = 0.5 * (np.sum(v * z**2 / (1.0 + v * D), axis=1) - np.sum(np.log1p(v * D), axis=1))
    best = int(np.argmax(gains))
    value = float(np.logaddexp.reduce(gains) - np.log(len(gains)))
    variance = scales[best] ** 2
    c = U @ (variance * z / (1.0 + variance * D))
    return Score(
        candidate=candidate,
        log_bayes=value + log_prior(candidate.effect),
        amplitude=float(c[0]),
        scale=float(scales[best]),
        length=float(np.sqrt(max(A[0, 0], 0.0))),
        further=tuple(c[len(c) - _further_columns(candidate) :].tolist()),
    )


def _further_columns(candidate: Candidate) -> int:
    """Return how many of its columns, at the end, are further sizes of all configurations."""
    effect = candidate.effect
    if effect is None or effect.by_configuration:
        return 0
    return sum(k.estimated for k in effect.parameters)


def averaged(log_bayes: Sequence[float]) -> float:
    """Return ln of the mean Bayes factor of shapes that are equally probable beforehand."""
    return float(np.logaddexp.reduce(log_bayes) - np.log(len(log_bayes)))


def allowed(one: Score) -> bool:
    """Return whether the size is one that the effect can have: some have a sign."""
    effect = one.candidate.effect
    if effect is None:
        return True
    if not effect.differs((one.amplitude, *one.further)):
        return False
    size = effect.amplitude
    value = unit_values(effect, one.candidate.values, one.amplitude)[size.name]
    if size.starting_values:
        return one.amplitude > 0.0 or size.low < 0.0
    return min(size.low, BOUNDS_FACTOR * size.low) <= value <= BOUNDS_FACTOR * size.high


def log_prior(effect: Effect | None) -> float:
    """Ln of how much less likely an effect is beforehand than one that says one thing.

    That something is there, and differs from session to session, are two names in one.
    """
    return 0.0 if effect is None else -FURTHER_NAME_LN * (effect.claims - 1)


def surprise(one: Score) -> float:
    """Ln of how much less likely it was beforehand: it says more, or its sign is unusual."""
    effect = one.candidate.effect
    prior = log_prior(effect)
    if effect is None or effect.amplitude.expected_sign == 0.0:
        return prior
    size = effect.amplitude
    value = unit_values(effect, one.candidate.values, one.amplitude)[size.name]
    unusual = (value - size.neutral) * size.expected_sign < 0.0
    return prior + UNEXPECTED_SIGN_LN if unusual else prior


def rescored(fitted: MixedModelFit, one: Score) -> tuple[float, Solution]:
    """Return the evidence with the noise estimated together with the candidate.

    Otherwise the candidate would hide in the noise. The same candidate is judged once.
    """
    kept = fitted.linear.at_states
    key = ("rescored", id(fitted.solution), id(one.candidate), one.scale)
    if key not in kept:  # with both, so that nothing else can have their identity
        kept[key] = (fitted.solution, one.candidate, *_rescored(fitted, one))
    _, _, gain, solution = kept[key]
    return float(gain), solution


def _rescored(fitted: MixedModelFit, one: Score) -> tuple[float, Solution]:
    from model.identification.likelihood.linearisation import with_columns

    forward = fitted.problem.forward
    q = one.candidate.columns.shape[1]
    best, kept, scale = -np.inf, fitted.solution, one.scale
    inside = prior_terms(fitted.linear, fitted.problem.bases.size)  # of the effects in the model
    while scale <= 1.01 * max(one.candidate.sizes):
        linear = with_columns(forward, fitted.linear, one.candidate.columns, scale**-2.0)
        guess = fitted.problem.guess
        solution = estimate(linear.data, guess, kept.log_sigma, 0.02, there=kept)
        value = solution.deviance + 2.0 * q * float(np.log(scale)) + inside
        gain = 0.5 * (fitted.deviance - value)
        if gain <= best:
            break
        # only a candidate that is worth something is worth another size
        best, kept, scale = gain, solution, 3.0 * scale if gain > 2.0 else np.inf
    return best - float(np.log(len(one.candidate.sizes))), kept


def unit_values(effect: Effect, values: Values, amplitude: float) -> dict[str, float]:
    """Return values of an effect whose columns were found with this amplitude."""
    size, result = effect.amplitude, dict(values)
    if not size.starting_values and size.log:
        result[size.name] = size.neutral * float((values[size.name] / size.neutral) ** amplitude)
    elif not size.starting_values:
        result[size.name] = size.neutral + amplitude * (values[size.name] - size.neutral)
    return result
