"""Decide from the search: which effects are named, and what stays unknown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from model.discrepancy.answers.calibrated_answers import Judged, calibrated, is_name
from model.discrepancy.answers.choice_set import ChoiceSet
from model.discrepancy.answers.compared_answers import ComparedAnswers
from model.discrepancy.answers.hidden_names import chances_beside_unknown, hidden_chances
from model.discrepancy.criticism.cell_noise import unusual_cell_noise
from model.discrepancy.criticism.criticise import Criticism, criticise
from model.discrepancy.criticism.image_noise import of_images, unusual_images
from model.discrepancy.criticism.named_model import NamedModel
from model.discrepancy.criticism.set_up_scatter import unusual_set_ups
from model.discrepancy.search.cross_validation import predictive_gains
from model.discrepancy.search.forward_selection import SearchResult, supported
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.thresholds import (
    FEWEST_POSITIONS,
    MISSED_BY_FORM_SHARE,
    NONPARAMETRIC_MARGIN_LN,
    PROBABLE_ALL_THE_SAME,
    PROBABLE_BESIDE_UNKNOWN,
    UNEXPLAINED_SHARE,
)
from model.discrepancy.verdict.free_form_or_names import (
    alone,
    explaining_as_much,
    misses_much,
    name_beside,
    stands_beside,
)
from model.discrepancy.verdict.inferred_form import unknown_of, with_free_form
from model.discrepancy.verdict.likely_locations import likely_locations
from model.discrepancy.verdict.posterior import (
    Choice,
    ResidualTerms,
    choice,
    choices,
    residual_terms,
    with_shapes,
)
from model.discrepancy.verdict.probable_names import (
    beside_strict_form,
    improbable,
    maybe_absent,
    of_others,
    pieces,
)
from model.discrepancy.verdict.result import Unknown
from model.effects import Effect
from model.identification.likelihood.mixed_model_fit import MixedModelFit, fit_mixed_model
from model.identification.likelihood.model_state import Found

PAIR = 2  # names that one nonparametric term may stand for


@dataclass(frozen=True, kw_only=True)
class Decision:
    """The decision at the end of the search."""

    named: list[Choice]
    known: MixedModelFit  # with the effects that are named
    unknown: Unknown | None
    final: MixedModelFit  # with the free form of what is unknown, too
    free: RankedCandidate | None = None  # that form
    residual: ResidualTerms | None = None  # what nonparametric terms find beside the names
    criticism: Criticism = field(default_factory=Criticism)
    choice_sets: tuple[ChoiceSet, ...] = ()  # of the questions that it answers
    answers: tuple[Judged, ...] = ()  # to each of them
    # a nonparametric term explains more than any name: several names may imitate one thing
    nonparametric_explains_more: bool = False
    hidden: Mapping[str, float] = field(default_factory=dict)  # see `hidden_names`
    beside: bool = False  # whether the name was found beside what is unknown


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """A finished search, about to be decided."""

    outcome: SearchResult
    effects: Sequence[Effect]  # that were considered
    threshold: float
    enough: bool  # set-ups, to estimate the scatter between them

    def decision(self) -> Decision:
        """Return the effects named, the unknown term, or both, after the criticism."""
        found = self._revised(self._beside_cell_noise(self.uncriticised()))
        found = self._with_name_beside(found) or found
        return replace(
            found,
            nonparametric_explains_more=self.outcome.best_nonparametric > self.outcome.best_name,
            hidden=self._hidden(found),
        )

    def _with_name_beside(self, found: Decision) -> Decision | None:
        """Return the decision with a name beside something unknown that stands alone; or None."""
        if found.unknown is None or found.free is None or found.named:
            return None
        beside = name_beside(
            self.outcome.base, found.final, found.free, self.effects, self.threshold
        )
        if beside is None:
            return None
        residual = self._residual_terms(beside.known)
        if residual is None or not self._unexplained(residual):
            return None
        both = self._with_unknown([beside.named], beside.known, residual)
        both = self._revised(replace(both, beside=True), settled=True)
        name = beside.named.effect.name
        asked = zip(both.choice_sets, both.answers, strict=True)
        chance = max((j.probabilities.get(name, 0.0) for a, j in asked if a.considered == name),
                     default=0.0)  # fmt: skip
        likely = both.named and both.unknown is not None and chance >= PROBABLE_BESIDE_UNKNOWN
        return both if likely else None

    def _hidden(self, found: Decision) -> dict[str, float]:
        """Return the names that may be there besides, with their probability."""
        if found.unknown is not None:
            return chances_beside_unknown(self.outcome.base, found.final, self.effects)
        # what several names leave may be anything
        return hidden_chances(found.known, self.effects) if len(found.named) == 1 else {}

    def uncriticised(self) -> Decision:
        """Return what the evidence names."""
        base = self.outcome.base
        named, known = choices(self.outcome, self.effects, self.threshold)
        residual = self._residual_terms(known)
        if self._unexplained(residual) and len(named) < len(self.outcome.chosen):
            # what was taken for the rest of another one's form is more than that
            more, full = choices(self.outcome, self.effects, self.threshold, rests=True)
            beside = self._residual_terms(full)
            if not self._unexplained(beside):
                named, known, residual = more, full, beside
        only = residual is not None and self._alone(residual, named, known)
        if residual is None or not (only or self._unexplained(residual)):
            return self._with_names(named, known, residual)
        if only:
            named, known, residual = [], base, self._residual_terms(base) or residual
        return self._with_unknown(named, known, residual)

    def _with_names(
        self, named: list[Choice], known: MixedModelFit, residual: ResidualTerms | None
    ) -> Decision:
        known = with_shapes(known, named)
        return Decision(named=named, known=known, unknown=None, final=known, residual=residual)

    def _with_unknown(
        self, named: list[Choice], known: MixedModelFit, residual: ResidualTerms
    ) -> Decision:
        """Return the names with the nonparametric term that is left beside them."""
        base = self.outcome.base
        free = residual.first if known is base or residual.last is None else residual.last
        at = base if free is residual.first else known
        final, known = with_free_form(known, free), with_shapes(known, named)
        others = self.outcome.steps[0].ranking if at is base else residual.ranking
        unknown = replace(unknown_of(at, free), locations=likely_locations(free, others))
        return Decision(
            named=named, known=known, unknown=unknown, final=final, free=free, residual=residual
        )

    def _beside_cell_noise(self, found: Decision) -> Decision:
        """Return the decision with what the load cell's noise hides beside the names.

        It takes the place of something unknown that was found with so much noise;
        what hides in the noise of curves stays.
        """
        in_pictures = found.free is not None and of_images(found.free)
        hidden = unusual_cell_noise(found.known) if found.named and not in_pictures else None
        if found.residual is None or hidden is None or hidden.term is None:
            return found
        residual = found.residual.instead(hidden.ranking, found.known, self.outcome.base)
        return self._with_unknown(found.named, found.known, residual)

    def _judged(self, found: Decision) -> NamedModel:
        """Return the names with their model, and what the load cell's noise hides beside them."""
        if found.beside:
            return NamedModel(self.outcome, found.named, found.final, found.known)
        hidden = unusual_cell_noise(found.known) if found.named and found.unknown else None
        if hidden is None or found.free is not hidden.term:
            return NamedModel(self.outcome, found.named, found.known)
        return NamedModel(self.outcome, found.named, found.final, found.known)

    def _revised(self, found: Decision, *, settled: bool = False) -> Decision:
        """Return the decision without names that the checks reject.

        Unless it is `settled`, a name gives way to a likelier one of the same question first.
        """
        judged = self._judged(found)
        criticism = criticise(judged)
        choice_sets = ComparedAnswers(
            judged=judged,
            residual=found.residual,
            unknown=found.unknown is not None,
            criticism=criticism,
        ).choice_sets()
        answers = tuple(calibrated().judged(one) for one in choice_sets)
        other = None
        if not settled:
            # what the load cell's noise hides is looked for again beside the other name
            those = found if judged.plain is None else replace(found, unknown=None)
            other = self._as_one(judged, found) or self._with_likelier(those, answers, criticism)
        if other is not None:
            return self._revised(self._beside_cell_noise(other), settled=True)
        names = [one.effect.name for one in found.named]
        asked = dict(zip(names, answers, strict=False))
        wrong = {
            name for name, one in asked.items()
            if improbable(one) or maybe_absent(name, one, found.known.found)
        }  # fmt: skip
        wrong |= {
            name for name in criticism.doubted(names)
            if asked[name].probabilities.get(name, 0.0) < PROBABLE_ALL_THE_SAME
        }  # fmt: skip
        # whichever name it is, not which one
        wrong |= {
            name for name in pieces(found.named)
            if of_others(asked[name], {*names} - {name}) < PROBABLE_ALL_THE_SAME
        }  # fmt: skip
        rejected = [n for n in names if n in {*wrong, *criticism.rejected(names)}]
        if not settled and len(rejected) == len(names) == 1 and found.unknown is None:
            passed = self._rival_that_passes(found.named[0], criticism)
            if passed is not None:
                return passed
        if rejected or (criticism.incomplete and found.unknown is None):
            found = self._without(found, rejected)
        return replace(found, criticism=criticism, choice_sets=choice_sets, answers=answers)

    def _rival_that_passes(self, one: Choice, criticism: Criticism) -> Decision | None:
        """Return the decision with a name that explains as much as one that fails; None: none does.

        What fails says only that it is not this one.
        """
        for name in criticism.rivals(one.effect.name):
            rival = next((c for c in one.ranking if c.name == name and c.known), None)
            if rival is None or rival.fitted is None or not supported(one.before, rival.fitted):
                continue
            residual = self._residual_terms(rival.fitted)
            if self._unexplained(residual):
                continue
            instead = choice(rival, one.ranking, one.before)
            other = self._revised(self._with_names([instead], rival.fitted, residual), settled=True)
            if other.named and other.unknown is None:
                return other
        return None

    def _as_one(self, judged: NamedModel, found: Decision) -> Decision | None:
        """Return the decision with a single name that explains more than several; None: none does.

        The search did not find it because another name explained more by itself.
        """
        for one in () if found.unknown else judged.single_names:
            fitted = one.candidate.fitted
            if one.ahead <= 0.0 or fitted is None:
                break
            residual = self._residual_terms(fitted)
            if self._unexplained(residual) or not supported(self.outcome.base, fitted):
                continue
            ranking = [c for c in self.outcome.steps[0].ranking if c.name != one.candidate.name]
            ranking = sorted([one.candidate, *ranking], key=lambda c: -c.ln_bayes_factor)
            named = [choice(one.candidate, ranking, self.outcome.base)]
            return self._with_names(named, fitted, residual)
        return None

    def _with_likelier(
        self, found: Decision, answers: Sequence[Judged], criticism: Criticism
    ) -> Decision | None:
        """Return the decision with the likeliest name of a question; None: it has them all.

        The evidence of all data in the catalogue's wording decides in the search; what left-out
        data choose, and other wordings, count here.
        """
        if found.unknown is not None:
            return self._with_name_of_unknown(found, answers[-1])
        names = {one.effect.name for one in found.named}
        for i, (one, judged) in enumerate(zip(found.named, answers, strict=False)):
            for name in (criticism.likelier(one.effect.name), judged.likeliest):
                rival = next((c for c in one.ranking if c.name == name and c.known), None)
                if name in names or rival is None or rival.fitted is None:
                    continue
                residual = self._residual_terms(rival.fitted)
                if self._unexplained(residual):
                    continue
                named = list(found.named)
                named[i] = choice(rival, one.ranking, one.before)
                return self._with_names(named, rival.fitted, residual)
        return None

    def _with_name_of_unknown(self, found: Decision, judged: Judged) -> Decision | None:
        """Return the decision with a name in place of 'unknown'; None: there is none.

        One that is likelier, or else that which explains as much with the usual scatter.
        """
        if found.named:
            return None
        step = self.outcome.steps[0]
        fitted = [c for c in step.ranking if c.known and c.fitted is not None]
        if is_name(judged.likeliest):
            some = [c for c in fitted if c.name == judged.likeliest]
        else:
            some = [] if found.residual is None else explaining_as_much(
                self.outcome.base, found.residual, [c for c in fitted if c.ln_bayes_factor > 0.0]
            )  # fmt: skip
        one = next(iter(some), None)
        if one is None or one.fitted is None or not supported(step.before, one.fitted):
            return None
        named = [choice(one, step.ranking, step.before)]
        return self._with_names(named, one.fitted, self._residual_terms(one.fitted))

    def _without(self, found: Decision, rejected: Sequence[str]) -> Decision:
        """Return a decision without these names, and with the best nonparametric term instead."""
        base, named = self.outcome.base, [c for c in found.named if c.effect.name not in rejected]
        known = found.known
        if rejected:
            kept = self._kept(known.found, rejected)
            known = fit_mixed_model(known.problem, known.theta, kept) if named else base
        residual = self._with_hidden(residual_terms(self.outcome, known, self.effects), known)
        if residual is not None and self._alone(residual, named, known):
            named, known = [], base
        hidden = unusual_cell_noise(known) if named else None
        if residual is not None and hidden is not None and hidden.term is not None:
            residual = residual.instead(hidden.ranking, known, base)
        if residual is None or self._worth(residual, known) < self.threshold:
            if not rejected:
                return found  # doubtful names, and nothing better
            if named:  # nothing takes the place of those that are rejected
                return self._with_names(named, known, residual)
            return Decision(named=[], known=base, unknown=None, final=base)
        return self._with_unknown(named, known, residual)

    def _kept(self, found: Sequence[Found], rejected: Sequence[str]) -> tuple[Found, ...]:
        """Return the effects that stay, in the forms that they had before those were found."""
        kept = tuple(one for one in found if one.effect.name not in rejected)
        dropped = any(beside_strict_form(name, found) for name in rejected)
        if not dropped or any(beside_strict_form(one.effect.name, kept) for one in kept):
            return kept
        forms = {one.name: one.fitted.found[-1].form for one in self.outcome.chosen if one.fitted}
        return tuple(replace(one, form=forms.get(one.effect.name, one.form)) for one in kept)

    def _worth(self, residual: ResidualTerms, known: MixedModelFit) -> float:
        """Return the evidence of the nonparametric term that is left, names being uncertain."""
        return (
            residual.first.ln_bayes_factor
            if known is self.outcome.base
            else residual.ln_bayes_factor_beside
        )

    def _residual_terms(self, known: MixedModelFit) -> ResidualTerms | None:
        """Return what nonparametric terms find beside the names."""
        if not self.enough:
            return None
        return self._with_hidden(residual_terms(self.outcome, known, self.effects), known)

    def _with_hidden(
        self, residual: ResidualTerms | None, known: MixedModelFit
    ) -> ResidualTerms | None:
        """Return the rest with what hides in noise or scatter, unless it is another one.

        That is in the noise of curves; or, where nothing is named, in the scatter of set-ups.
        """
        if residual is None or self._unexplained(residual):
            return residual
        base = self.outcome.base
        hidden = unusual_images(known) or (unusual_set_ups(known) if known is base else [])
        return residual.instead(hidden, known, base) if hidden else residual

    def _alone(
        self, residual: ResidualTerms, named: Sequence[Choice], known: MixedModelFit
    ) -> bool:
        """Return whether a nonparametric term stands for all names.

        Two names of two locations may be of other forms, too, as long as left-out positions are
        predicted as well with them: the term has to know what the names do not.
        """
        base, single = self.outcome.base, self.outcome.best_name
        if not alone(residual, base, known, single):
            return False
        if any(stands_beside(base, residual.first, one) for one in named):
            return False
        if len(named) == 1 and not of_images(residual.first):
            return misses_much(base, residual, named[0])
        missed = residual.first.ln_bayes_factor * (1.0 - MISSED_BY_FORM_SHARE)
        explained = 0.5 * (base.deviance - known.deviance)
        small = missed <= explained + NONPARAMETRIC_MARGIN_LN
        if len(named) != PAIR or pieces(named) or not small:
            return True
        gains = predictive_gains(known, with_free_form(base, residual.first))
        return len(gains) < FEWEST_POSITIONS or float(np.sum(gains)) > NONPARAMETRIC_MARGIN_LN

    def _unexplained(self, residual: ResidualTerms | None) -> bool:
        """Return whether that exceeds the rest of a form."""
        if residual is None or residual.share < UNEXPLAINED_SHARE:
            return False
        return residual.ln_bayes_factor_beside >= self.threshold + NONPARAMETRIC_MARGIN_LN
