"""Look for further names beside names in the catalogue's own forms.

A form may differ from the catalogue's, and the smooth deviation of a strong effect may be a weak
effect of another name: then nothing is left of it in the residual. Beside forms that hardly differ
it stands out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from model.discrepancy.search.beside_others import ROUGH, evidence_beside
from model.discrepancy.search.evidence import candidates
from model.discrepancy.search.ranking import RankedCandidate, best_scores, rank, usual_scatter
from model.discrepancy.search.refinement.other_starts import STRICT
from model.effects.interface import Effect
from model.identification.likelihood.mixed_model import estimate
from model.identification.likelihood.mixed_model_fit import MixedModelFit, prior_terms

# Log Bayes factor with the usual scatter, below which a name is too weak with any other
WORTH_RANKING_LN = 2.0


@dataclass(frozen=True, kw_only=True)
class HiddenName:
    """A further name that the forms of others may hide."""

    name: str
    ln_bayes_factor: float  # its evidence beside the catalogue's forms
    ahead: float  # how much more they explain with it than forms that differ do without it, ln


@dataclass(frozen=True, kw_only=True)
class StrictForms:
    """A model whose forms hardly differ from the catalogue's, and what may be added to it."""

    fitted: MixedModelFit
    lost: float  # how much less evidence it has, ln; at least 0
    ranking: Sequence[RankedCandidate]  # names that may be there besides, the best first

    @staticmethod
    def of(fitted: MixedModelFit, effects: Sequence[Effect]) -> StrictForms:
        """At the states of a model with names; it is made once."""
        kept, of = fitted.linear.at_states, (fitted.solution, *effects)
        key = ("strict forms", *map(id, of))
        if key not in kept:  # with all of it, so that nothing else can have their identity
            strict = _with_strict_forms(fitted)
            lost = max(0.5 * (strict.deviance - fitted.deviance), 0.0)
            made = StrictForms(fitted=strict, lost=lost, ranking=_ranking(strict, effects))
            kept[key] = of, made
        result: StrictForms = kept[key][1]
        return result


def hidden_names(fitted: MixedModelFit, effects: Sequence[Effect]) -> list[HiddenName]:
    """Return the further names beside those of a model, the best first; none: it has no names.

    Their evidence is that where the contributions of the others are uncertain by a few per cent.
    """
    if not fitted.found:
        return []
    strict = StrictForms.of(fitted, effects)
    worth = [(one.name, evidence_beside(strict.fitted, one)) for one in strict.ranking]
    return [
        HiddenName(name=n, ln_bayes_factor=ln_bayes_factor, ahead=ln_bayes_factor - strict.lost)
        for n, ln_bayes_factor in worth
    ]


def _ranking(strict: MixedModelFit, effects: Sequence[Effect]) -> list[RankedCandidate]:
    """Return names ranked with the scatter estimated, if the usual one leaves them anything."""
    inside = {one.effect.name for one in strict.found}
    every = candidates(strict, [one for one in effects if one.name not in inside])
    usual = best_scores(strict, every, usual_scatter(strict))
    some = [e for e in effects if e.name in usual and usual[e.name].log_bayes > WORTH_RANKING_LN]
    return [one for one in rank(strict, some, locations=False) if one.known] if some else []


def _with_strict_forms(fitted: MixedModelFit) -> MixedModelFit:
    data = fitted.linear.data
    precision = data.precision.copy()
    for one, span in zip(fitted.found, fitted.spans, strict=True):
        precision[span.start + len(one.parameters()) : span.stop] /= (STRICT / one.form) ** 2
    linear = replace(fitted.linear, data=replace(data, precision=precision))
    solution = estimate(linear.data, fitted.problem.guess, fitted.solution.log_sigma, ROUGH)
    return replace(
        fitted, linear=linear, solution=solution,
        deviance=solution.deviance + prior_terms(linear, fitted.problem.bases.size),
        found=tuple(replace(one, form=STRICT) for one in fitted.found),
    )  # fmt: skip
