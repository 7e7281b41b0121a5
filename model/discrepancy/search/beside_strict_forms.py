"""Look for further names beside names in the catalogue's own forms.

A form may differ from the catalogue's, and the smooth deviation of a strong effect may be a weak
effect of another name: then nothing is left of it in the residual. Beside forms that hardly differ
it stands out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from model.discrepancy.search.beside_others import ROUGH
from model.discrepancy.search.ranking import rank
from model.discrepancy.search.refinement import STRICT
from model.effects.interface import Effect
from model.identification.likelihood.mixed_model import estimate
from model.identification.likelihood.mixed_model_fit import MixedModelFit, prior_terms


@dataclass(frozen=True, kw_only=True)
class HiddenName:
    """A further name that the forms of others may hide."""

    name: str
    gain: float  # its evidence beside the catalogue's forms
    ahead: float  # how much more they explain with it than forms that differ do without it, ln


def hidden_names(fitted: MixedModelFit, effects: Sequence[Effect]) -> list[HiddenName]:
    """Return the further names beside those of a model, the best first; none: it has no names."""
    if not fitted.found:
        return []
    strict, lost = with_strict_forms(fitted)
    return [
        HiddenName(name=one.name, gain=one.gain, ahead=one.gain - lost)
        for one in rank(strict, effects, locations=False)
        if one.known
    ]


def with_strict_forms(fitted: MixedModelFit) -> tuple[MixedModelFit, float]:
    """Return a model whose forms hardly differ from the catalogue's, at the same states.

    And how much less evidence it has; not less than none. It is made once.
    """
    kept, key = fitted.linear.at_states, ("strict forms", id(fitted.solution))
    if key not in kept:  # with it, so that nothing else can have its identity
        kept[key] = fitted.solution, _with_strict_forms(fitted)
    strict: MixedModelFit = kept[key][1]
    return strict, max(0.5 * (strict.deviance - fitted.deviance), 0.0)


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
