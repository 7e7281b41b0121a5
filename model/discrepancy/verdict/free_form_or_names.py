"""Whether one nonparametric term stands for what is named, and for which name it does not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from model.discrepancy.answers.hidden_names import chances_beside_unknown
from model.discrepancy.search.evidence import Projected, score
from model.discrepancy.search.form_share import form_share
from model.discrepancy.search.forward_selection import supported
from model.discrepancy.search.nonparametric_terms import nonparametric_replaces_names
from model.discrepancy.search.ranking import RankedCandidate, rank, usual_scatter
from model.discrepancy.search.refinement.best_candidates import refine_best
from model.discrepancy.thresholds import (
    EVIDENCE_THRESHOLD_LN,
    FORM_SHARE_LIMIT,
    FURTHER_EFFECT_LN,
    MISSED_BY_FORM_SHARE,
    NONPARAMETRIC_MARGIN_LN,
)
from model.discrepancy.verdict.inferred_form import with_free_form
from model.discrepancy.verdict.posterior import Choice, ResidualTerms, choice
from model.effects import Effect
from model.identification.likelihood.mixed_model_fit import (
    MixedModelFit,
    fit_mixed_model,
    without_free,
)
from model.measurements import ModelError

STANDING_SHARE = 0.7  # of what a name explains by itself, that it explains beside a free form


def alone(
    residual: ResidualTerms, base: MixedModelFit, known: MixedModelFit, single: float
) -> bool:
    """Return whether one free form explains more than all the names together.

    `single` is what the best name explains by itself.
    """
    names = len(known.found) - len(base.found)
    explained = 0.5 * (base.deviance - known.deviance)
    return nonparametric_replaces_names(residual.first.ln_bayes_factor, explained, names, single)


def misses_much(base: MixedModelFit, residual: ResidualTerms, name: Choice) -> bool:
    """Return whether a single name misses more than its form may, set-ups being as usual.

    Where set-ups may differ as much as the data ask for, they take up most of what goes from one to
    the next. Little evidence is left of either, and of that a right name may miss a good part.
    """
    own = [c for c in name.ranking if c.name == name.effect.name]
    return not explaining_as_much(base, residual, own)


def explaining_as_much(
    base: MixedModelFit, residual: ResidualTerms, names: Sequence[RankedCandidate]
) -> list[RankedCandidate]:
    """Return the names that miss no more of a free form than theirs allows, the best first."""
    free = _at_usual_scatter(base, residual.first) * (1.0 - MISSED_BY_FORM_SHARE)
    each = [(_at_usual_scatter(base, one), one) for one in names]
    some = [pair for pair in each if pair[0] + NONPARAMETRIC_MARGIN_LN >= free]
    return [one for _, one in sorted(some, key=lambda pair: -pair[0])]


def stands_beside(base: MixedModelFit, free: RankedCandidate, name: Choice) -> bool:
    """Return whether a name explains beside a free form most of what it explains alone.

    Then it imitates nothing of that: both are there.
    """
    own = next((c for c in name.ranking if c.name == name.effect.name), None)
    if own is None or name.before is not base:
        return False
    forward = base.problem.forward

    def explained(fitted: MixedModelFit) -> float:
        projected = Projected.of(forward, fitted.linear, fitted.solution)
        return score(forward, projected, own.score.candidate).log_bayes

    beside = explained(with_free_form(base, free))
    enough = EVIDENCE_THRESHOLD_LN + NONPARAMETRIC_MARGIN_LN
    return beside > max(enough, STANDING_SHARE * explained(base))


@dataclass(frozen=True, kw_only=True)
class NameBeside:
    """A name that was fitted with a free form in the model."""

    named: Choice
    known: MixedModelFit  # at the same place, without the free form


def name_beside(
    base: MixedModelFit,
    final: MixedModelFit,
    free: RankedCandidate,
    effects: Sequence[Effect],
    threshold: float,
) -> NameBeside | None:
    """Return the name that the data ask for beside a free form; None: there is none, or no fit.

    With the free form in the model (`final` has it) little is left to what it imitates.
    """
    asked = chances_beside_unknown(base, final, effects)
    if not asked or base.problem.effort.spent():
        return None
    columns, precision = free.score.candidate.columns, free.score.scale**-2.0
    try:
        before = fit_mixed_model(
            replace(base.problem, free=(columns, precision)), base.theta, base.found,
            final.solution.log_sigma,
        )  # fmt: skip
        ranking = refine_best(before, rank(before, effects, locations=False))
        one = next((c for c in ranking if c.known), None)
        if one is None or one.fitted is None or one.name not in asked:
            return None
        enough = one.ln_bayes_factor >= threshold + FURTHER_EFFECT_LN + NONPARAMETRIC_MARGIN_LN
        loose = form_share(one.fitted, len(one.fitted.found) - 1) > FORM_SHARE_LIMIT
        if not enough or loose or not supported(before, one.fitted):
            return None
        return NameBeside(named=choice(one, ranking, before), known=without_free(one.fitted))
    except ModelError:  # the free form, taken as a straight line, leads where nothing settles
        return None


def _at_usual_scatter(fitted: MixedModelFit, one: RankedCandidate) -> float:
    """Return the evidence of a candidate, as far as a straight line goes."""
    forward = fitted.problem.forward
    projected = Projected.of(forward, fitted.linear, usual_scatter(fitted))
    return score(forward, projected, one.score.candidate).log_bayes
