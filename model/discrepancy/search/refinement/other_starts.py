"""Fits of effects that begin elsewhere than where a straight line from the model without leads."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import islice

import numpy as np

from model.discrepancy.search.evidence import Projected, Score, candidates, scored
from model.discrepancy.search.form_share import form_share
from model.discrepancy.search.ranking import RankedCandidate, best_scores, usual_scatter
from model.discrepancy.search.refinement.fits import (
    beginning,
    begun_at,
    better,
    doubtful,
    settled,
)
from model.discrepancy.thresholds import FORM_SHARE_LIMIT
from model.effects.interface import Effect
from model.identification.likelihood.mixed_model_fit import MixedModelFit, approach
from model.identification.likelihood.model_state import FitPlace, Found
from model.measurements import FloatArray, ModelError

STRICT = 0.1  # of the tolerance of a form, where its size is looked for first
ROUGH_STEPS = 2  # of a fit that only says where to begin
VAGUE_M = 1.0  # of numbers that are not to count


def refined_again(
    fitted: MixedModelFit,
    candidate: RankedCandidate,
    least: float,
    begins: Sequence[Callable[[], FloatArray]],
) -> RankedCandidate:
    """From other beginnings: a straight line from where the effect is absent may lead nowhere.

    It begins at a usual size or where it leads with the usual scatter, lets nothing hide in
    scatter or form, and only then lets the form differ; not twice from the same place.
    """
    places: list[FitPlace] = []
    for one in _begun_with(fitted, candidate):
        found = (*fitted.found, _usual(fitted, one))
        for begin in begins:
            strict = _approached(fitted, begin(), found, places)
            if strict is None:
                continue
            places.append(strict)
            candidate = _freed(fitted, candidate, one, strict)
            if not doubtful(candidate, least):
                return candidate
    return candidate


def _begun_with(fitted: MixedModelFit, candidate: RankedCandidate) -> Iterator[Score]:
    """Yield a shape to begin with, and the middle one of sizes that are tried one by one.

    Straight lines of strong effects lead far off, to where there is no equilibrium.
    """
    yield candidate.score
    effect = candidate.score.candidate.effect
    if effect is not None and effect.amplitude.starting_values:
        middle = of_tried_size(fitted, effect, 0.5)
        if middle.candidate.values != candidate.score.candidate.values:
            yield middle


def of_tried_size(fitted: MixedModelFit, effect: Effect, rank: float) -> Score:
    """Return an effect in one of its shapes, of the size that is tried.

    `rank` 0 is the weakest one, which changes the data least; 1 the strongest.
    """
    pool, forward = candidates(fitted, [effect]), fitted.problem.forward
    scores = scored(forward, Projected.of(forward, fitted.linear, fitted.solution), pool)
    ordered = sorted(scores, key=lambda one: one.length)
    return replace(ordered[int(np.ceil(rank * (len(ordered) - 1)))], amplitude=1.0)


def weakest(fitted: MixedModelFit, one: Score) -> tuple[Score, ...]:
    """Return an effect along the sheet of which sizes are tried in its weakest shape, if another.

    A fit from there is near the base model, so its form bends to the data as a straight line does.
    One from a size that is too large may settle where the form undoes a good part of it along the
    sheet. Forms in time have no such place.
    """
    effect = one.candidate.effect
    if effect is None or not effect.amplitude.starting_values:
        return ()
    if "s" not in effect.form_error_along:
        return ()
    weak = of_tried_size(fitted, effect, 0.0)
    return () if weak.candidate.values == one.candidate.values else (weak,)


def by_forces(fitted: MixedModelFit) -> FloatArray:
    """Return the base parameters fitted to forces and to the curves at 0 V, roughly.

    Curves under voltage may contain the effect that is to be explained. Fits begin there: two steps
    bring them as near as they need to be.
    """
    problem, forward = fitted.problem, fitted.problem.forward
    vague = np.zeros(forward.row_index.size)
    for block, configuration_model in zip(
        forward.row_index.blocks, forward.configuration_models, strict=True
    ):
        vague[block.mode_rows[configuration_model.voltage_V != 0.0].ravel()] = (
            VAGUE_M * forward.scale.length
        ) ** 2
    noise = replace(problem.noise, fixed=problem.noise.fixed + vague)
    theta = fitted.theta
    with suppress(ModelError):
        steps = approach(replace(problem, noise=noise), fitted.theta, fitted.found)
        for there in islice(steps, ROUGH_STEPS):
            theta = there.theta
    return theta


def _usual(fitted: MixedModelFit, one: Score) -> Found:
    """Return an effect of a usual size at least, or where it leads with the usual scatter."""
    name = one.candidate.name
    usual = best_scores(fitted, [one.candidate], usual_scatter(fitted)).get(name)
    size = 1.0 if usual is None else usual.amplitude
    return begun_at(fitted, one, float(np.copysign(max(1.0, abs(size)), size)))


def _freed(
    fitted: MixedModelFit, candidate: RankedCandidate, one: Score, strict: FitPlace
) -> RankedCandidate:
    """Return the candidate with a fit from there whose form may differ, where it is better."""
    freed = settled(fitted, strict.theta, strict.found, strict.log_sigma)
    candidate = better(fitted, candidate, one, freed)
    if freed is None or form_share(freed, -1) > FORM_SHARE_LIMIT:
        # its deviation may have taken the place of its size: the catalogue's form may do
        bound = (*strict.found[:-1], replace(strict.found[-1], form=STRICT))
        kept = settled(fitted, strict.theta, bound, strict.log_sigma)
        candidate = better(fitted, candidate, one, kept)
    return candidate


def _approached(
    fitted: MixedModelFit, theta: FloatArray, found: tuple[Found, ...], known: Sequence[FitPlace]
) -> FitPlace | None:
    """Return where a fit leads whose forms may hardly differ; None: nowhere, or to a known place.

    As in `settled`, it is made once from the same beginning.
    """
    kept, key = fitted.linear.at_states, ("approached", *beginning(fitted, theta, found, None))
    sigma = np.sqrt(np.maximum(np.diag(fitted.solution.covariance), 0.0))
    if key not in kept:
        try:
            for there in approach(fitted.problem, theta, found, None, STRICT):
                if any(there.near(one, sigma) for one in known):
                    return None
            kept[key] = there
        except ModelError:
            kept[key] = None
    result: FitPlace | None = kept[key]
    return result
