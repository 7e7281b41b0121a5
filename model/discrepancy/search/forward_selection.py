"""Forward selection: add the best candidate while its evidence exceeds the threshold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from model.discrepancy.search.beside_others import evidence_beside
from model.discrepancy.search.beside_strict_forms import StrictForms
from model.discrepancy.search.cross_validation import predictive_gains
from model.discrepancy.search.form_share import form_share
from model.discrepancy.search.nonparametric_terms import (
    is_nonparametric,
    nonparametric_replaces_names,
)
from model.discrepancy.search.order_of_positions import positions_in_order
from model.discrepancy.search.outliers import numbers_of, without
from model.discrepancy.search.ranking import RankedCandidate, rank
from model.discrepancy.search.refinement.best_candidates import refine_best
from model.discrepancy.search.refinement.fits import strained
from model.discrepancy.search.refinement.impossible_signs import with_impossible_signs
from model.discrepancy.thresholds import (
    EQUAL_EVIDENCE_LN,
    FEWEST_POSITIONS,
    FORM_SHARE_LIMIT,
    FURTHER_EFFECT_LN,
    LOOSE_FORM_SHARE,
    MOST_EFFECTS,
    MOST_SOLUTIONS,
    ONE_POSITION_SHARE,
    OUTLIER_ROUNDS,
)
from model.effects import title
from model.effects.interface import Effect
from model.identification.likelihood.effort import Effort
from model.identification.likelihood.mixed_model_fit import (
    FitProblem,
    MixedModelFit,
    fit_mixed_model,
)
from model.identification.likelihood.model_state import Found
from model.measurements import FloatArray, Progress, silent


@dataclass
class SelectionStep:
    """One step of forward selection."""

    before: MixedModelFit
    ranking: list[RankedCandidate]
    chosen: RankedCandidate | None = None


@dataclass
class SearchResult:
    """The steps of forward selection, and the model it ends with."""

    base: MixedModelFit
    steps: list[SelectionStep]
    final: MixedModelFit
    outliers: list[int] = field(default_factory=list)  # numbers of conditions left out

    @property
    def chosen(self) -> list[RankedCandidate]:
        """The effects that were added, in their order."""
        return [step.chosen for step in self.steps if step.chosen is not None]

    @property
    def best_name(self) -> float:
        """Evidence of the best name by itself."""
        return max((c.ln_bayes_factor for c in self.steps[0].ranking if c.known), default=0.0)

    @property
    def best_nonparametric(self) -> float:
        """Evidence of the best nonparametric term by itself."""
        return max(
            (c.ln_bayes_factor for c in self.steps[0].ranking if is_nonparametric(c.name)),
            default=0.0,
        )

    @property
    def nonparametric_suffices(self) -> bool:
        """Whether one nonparametric term stands for all that was added."""
        return nonparametric_replaces_names(
            self.best_nonparametric, self.ln_bayes_factor, len(self.chosen), self.best_name
        )

    @property
    def ln_bayes_factor(self) -> float:
        """Evidence of all of them together."""
        return 0.5 * (self.base.deviance - self.final.deviance)


def supported(before: MixedModelFit, after: MixedModelFit) -> bool:
    """Whether positions that are left out speak for the effect, not just a single one of them."""
    gains = predictive_gains(before, after)
    if len(gains) < FEWEST_POSITIONS:
        return True
    total = float(np.sum(gains))
    return total > 0.0 and total - float(np.max(gains)) > -ONE_POSITION_SHARE * total


def search(
    problem: FitProblem,
    theta: FloatArray,
    effects: Sequence[Effect],
    threshold: float,
    most: int = MOST_EFFECTS,
    found: tuple[Found, ...] = (),
    report: Progress = silent,
) -> SearchResult:
    """Add effects while the data ask for them.

    An effect that is mostly deviation from its form may stand for several others: these are tried
    without it, and replace it where they explain more. `report` is called before each step, with
    the share of the search that is done at least. Nothing more is tried after so many solutions of
    the model: see `Effort`.
    """
    solutions = MOST_SOLUTIONS * max(most, MOST_EFFECTS) // MOST_EFFECTS
    problem = replace(problem, effort=Effort(solutions))
    fitted = fit_mixed_model(problem, theta, found)
    outcome = _several_forms(fitted, effects, threshold, most, report)
    return _with_hidden(outcome, effects, threshold, most)


def _several_forms(
    fitted: MixedModelFit, effects: Sequence[Effect], threshold: float, most: int, report: Progress
) -> SearchResult:
    """Return the names, without those whose forms stand for several others."""
    outcome = _forward(fitted, effects, threshold, most, report)
    loose = {c.name for c in outcome.chosen if _share(c) > LOOSE_FORM_SHARE}
    effort = fitted.problem.effort
    if not loose or most < 2 or outcome.nonparametric_suffices or effort.spent():
        return outcome
    rest = [e for e in effects if e.name not in loose]
    other = _forward(fitted, rest, threshold, most, report, LOOSE_FORM_SHARE)
    several = len(other.chosen) > 1 and all(_share(c) <= LOOSE_FORM_SHARE for c in other.chosen)
    return (
        other
        if several and other.ln_bayes_factor > outcome.ln_bayes_factor + EQUAL_EVIDENCE_LN
        else outcome
    )


def _with_hidden(
    outcome: SearchResult, effects: Sequence[Effect], threshold: float, most: int
) -> SearchResult:
    """Return the search with a second name that the form of the first one hides, if there is one.

    In the catalogue's form it has to explain more with it than in another form without it.
    """
    effort = outcome.final.problem.effort
    if len(outcome.chosen) != 1 or most < 2 or outcome.nonparametric_suffices or effort.spent():
        return outcome
    strict = StrictForms.of(outcome.final, effects)
    best = max((one.ln_bayes_factor for one in strict.ranking), default=-np.inf)
    if best < threshold + FURTHER_EFFECT_LN + strict.lost:
        return outcome
    step = SelectionStep(strict.fitted, refine_best(strict.fitted, list(strict.ranking)))
    step.chosen = _worth(step, threshold + strict.lost)
    if step.chosen is None or step.chosen.fitted is None:
        return outcome
    steps = [*(one for one in outcome.steps if one.chosen is not None), step]
    return replace(outcome, steps=steps, final=step.chosen.fitted)


def _share(candidate: RankedCandidate) -> float:
    """Return how much of an effect is deviation from its form."""
    return 0.0 if candidate.fitted is None else form_share(candidate.fitted, -1)


def _forward(
    fitted: MixedModelFit,
    effects: Sequence[Effect],
    threshold: float,
    most: int,
    report: Progress,
    largest_share: float = np.inf,
) -> SearchResult:
    """Add the best effect, and the best one then, while the data ask for them.

    It ends at one that is more deviation from its form than `largest_share`.
    """
    outcome, rounds_of_outliers = SearchResult(fitted, [], fitted), 0
    while len(outcome.steps) < most + 1:
        if outcome.steps and fitted.problem.effort.spent():
            break
        doing, share = f"searching for effect {len(outcome.steps) + 1}", 1 / (most + 1)
        report(share * len(outcome.steps), doing)
        step = SelectionStep(fitted, rank(fitted, effects))
        if not step.ranking or not _worth_fits(step, threshold):
            outcome.steps.append(step)
            break
        top, first = step.ranking[0], step.ranking[0].score.candidate
        clear = top.ln_bayes_factor >= threshold + FURTHER_EFFECT_LN
        if first.location == "outlier" and clear and rounds_of_outliers < OUTLIER_ROUNDS:
            rounds_of_outliers += 1
            fitted = _left_out(outcome, fitted, numbers_of(first.name))
            continue
        outcome.steps.append(step)
        if len(outcome.steps) > most:  # no more are named, and nothing is worth a fit
            break
        report(share * (len(outcome.steps) - 0.5), f"{doing}: {title(first.name)}")
        refined = refine_best(fitted, step.ranking)
        step.ranking = with_impossible_signs(fitted, refined, effects)
        step.chosen = _worth(step, threshold)
        if step.chosen is None or step.chosen.fitted is None:
            break
        fitted = step.chosen.fitted
        outcome.final = fitted
        if _share(step.chosen) > largest_share or nonparametric_replaces_any_names(outcome, most):
            break
    outcome.final = fitted
    return outcome


def _worth_fits(step: SelectionStep, threshold: float) -> bool:
    """Return whether a candidate may reach the threshold, by itself or by its fit.

    Where set-ups seem to differ much, a strong effect may hide: its straight line leaves much of
    the scatter, and its fit none. Not where it may go with time or position alike.
    """
    if step.ranking[0].ln_bayes_factor >= threshold:
        return True
    sheets = step.before.problem.forward.data_vectors
    return strained(step.before) and not positions_in_order(sheets)


def nonparametric_replaces_any_names(outcome: SearchResult, most: int) -> bool:
    """Return whether one nonparametric term stands for the names, however many are added.

    Each further one is taken to explain as much as the last one did; as a rule it is less.
    """
    names, last = len(outcome.chosen), outcome.chosen[-1].ln_bayes_factor
    return all(
        nonparametric_replaces_names(
            outcome.best_nonparametric,
            outcome.ln_bayes_factor + more * last,
            names + more,
            outcome.best_name,
        )
        for more in range(most - names + 1)
    )


def _left_out(outcome: SearchResult, fitted: MixedModelFit, numbers: list[int]) -> MixedModelFit:
    """Return the model without these conditions; the base is fitted without them, too."""
    outcome.outliers += numbers
    problem, base = without(fitted, numbers), outcome.base
    again = fit_mixed_model(problem, fitted.theta, fitted.found)
    nothing_new = len(fitted.found) == len(base.found)
    outcome.base = again if nothing_new else fit_mixed_model(problem, base.theta, base.found)
    return again


def _worth(step: SelectionStep, threshold: float) -> RankedCandidate | None:
    """Return the best effect of the catalogue whose form is in the data, if they ask for it."""
    threshold += FURTHER_EFFECT_LN if step.before.found else 0.0
    rest = _rest_of_forms(step)
    for one in step.ranking:
        if not one.known or one.fitted is None:
            continue
        worth, share = evidence_beside(step.before, one), form_share(one.fitted, -1)
        # beside others a deviation may be what is left of theirs: then the form itself must count
        itself = (1.0 - share) * worth if step.before.found else 0.0
        if share > FORM_SHARE_LIMIT and itself < threshold:
            continue
        asked = (
            min(one.ln_bayes_factor, worth) >= threshold
            and one.ln_bayes_factor > rest - EQUAL_EVIDENCE_LN
        )
        return one if asked and supported(step.before, one.fitted) else None
    return None


def _rest_of_forms(step: SelectionStep) -> float:
    """Return the largest gain of a nonparametric term at the location of an effect already found.

    Such a term is more likely a remainder of that effect's form than a further effect.
    """
    locations = {f"unknown:{f.effect.location}" for f in step.before.found}
    return max((c.ln_bayes_factor for c in step.ranking if c.name in locations), default=-np.inf)
