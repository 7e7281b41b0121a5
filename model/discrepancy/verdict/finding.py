"""Make the diagnosis from the search: names, verdict, prediction errors, next step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from model.discrepancy.answers.choice_set import NOTHING
from model.discrepancy.answers.reported_set import not_ruled_out, of_name, with_alternatives
from model.discrepancy.criticism.catalogue import origins as origins_of_checks
from model.discrepancy.criticism.cell_noise import unusual_cell_noise
from model.discrepancy.criticism.check_result import Consequence
from model.discrepancy.criticism.image_noise import of_images
from model.discrepancy.criticism.set_up_scatter import of_set_ups
from model.discrepancy.next_measurement.choice import next_measurement
from model.discrepancy.next_measurement.separation import Suspect, separated
from model.discrepancy.prepare import DiagnoseOptions, Prepared, setups
from model.discrepancy.search.cross_validation import left_out, left_out_rows, position_groups
from model.discrepancy.search.evidence import Candidate, candidates
from model.discrepancy.search.forward_selection import SearchResult
from model.discrepancy.search.outliers import condition_name
from model.discrepancy.search.ranking import RankedCandidate
from model.discrepancy.search.signatures import (
    classes,
    detection_limits,
    forms,
    invisible,
    lengths_beside,
    signatures,
)
from model.discrepancy.thresholds import (
    COMPARISON_SIGMA,
    CROSS_VALIDATED_NAMES,
    EXCESSIVE_SCATTER_RATIO,
    FEWEST_OUTLIERS,
    FEWEST_SETUPS,
    LEAST_GAIN_SIGMA,
    MOST_OUTLIERS_SHARE,
    NONPARAMETRIC_MARGIN_LN,
)
from model.discrepancy.verdict import prediction_error as gaps
from model.discrepancy.verdict.data_checks import place_or_time, remarks
from model.discrepancy.verdict.decision import Decision, Judgement
from model.discrepancy.verdict.inferred_form import form_of
from model.discrepancy.verdict.localisation import places
from model.discrepancy.verdict.messages import (
    cut_short,
    improbable,
    left_out_of_verdict,
    many_left_out,
    noisy,
    not_written,
    notes,
    open_answers,
    promise_note,
    refused,
    sentence,
    too_few,
    worse,
    written_instead,
)
from model.discrepancy.verdict.ordered_scatter import unusual_scatter
from model.discrepancy.verdict.posterior import (
    Choice,
    chosen_values,
)
from model.discrepancy.verdict.result import (
    BeforeAfter,
    ClosedGap,
    Diagnosis,
    ErrorRow,
    Gap,
    Named,
    Next,
    Promise,
    Ranked,
    Signatures,
    Unknown,
    Verdict,
)
from model.discrepancy.verdict.written_model.chosen import Writer, WrittenModel
from model.discrepancy.verdict.written_model.fitted_model import parameters_of
from model.effects import Effect, catalogue
from model.effects import origins as origins_of_effects
from model.identification.data.outlier_readings import left_out_readings
from model.identification.likelihood.mixed_model import weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.identification.likelihood.random_effects import ASSUMED
from model.identification.reading_patterns import origins as origins_of_patterns
from model.locations import origins as origins_of_locations
from model.measurements import Measurements, ModelError

Said = TypeVar("Said")


def _plugins() -> dict[str, str]:
    """Return the parts of other distributions that took part, each with its distribution."""
    return {
        **origins_of_locations(),
        **origins_of_patterns(),
        **origins_of_effects(),
        **origins_of_checks(),
    }


def _scatter(final: MixedModelFit) -> dict[str, float]:
    """From one set-up to the next, by name."""
    return dict(zip(ASSUMED, np.exp(final.solution.log_sigma).tolist(), strict=False))


@dataclass(frozen=True, kw_only=True)
class _LeftOut:
    """How base and final model do on positions that were left out."""

    gap: BeforeAfter
    closed: ClosedGap | None
    floor: Gap
    chosen: list[str]  # with each position left out
    rows: tuple[ErrorRow, ...]


@dataclass(frozen=True, kw_only=True)
class Finding:
    """A finished search, with its options and data."""

    measurements: Measurements
    options: DiagnoseOptions
    ready: Prepared
    outcome: SearchResult
    effects: Sequence[Effect]  # that were considered
    threshold: float
    threshold_from: str

    @cached_property
    def diagnosis(self) -> Diagnosis:
        """Return everything that is reported."""
        base, decision = self.outcome.base, self.decision
        pool = candidates(base, self.effects)
        seen = self._signatures(pool, decision)
        named = tuple(_named(c, decision, self.written.reported) for c in decision.named)
        unknown = decision.unknown and with_alternatives(decision.unknown, decision)
        told = {*_reported(named), *(unknown.confusable_with if unknown else ())}
        open_still = not_ruled_out(decision, told)
        beside, effects = self._beside(pool, decision), {e.name: e for e in self.effects}
        lengths = np.array([beside[name] for name in seen.names])
        unseen = _not_reported(
            invisible(base, replace(seen, detectability=lengths), effects), named
        )
        promises = self._promises()
        doubt = self._doubt(decision)
        verdict = self._verdict(named, unknown, doubt)
        cross_validated = self._left_out(pool, decision)
        noise, where = gaps.variance(decision.final), gaps.cells(base, self.outcome.outliers)
        reported = self.written.predicting
        fitted = BeforeAfter(*(gaps.gap(gaps.refitted(f), noise, where) for f in (base, reported)))
        return Diagnosis(
            verdict=verdict,
            sentence=self._sentence(verdict, named, unknown, cross_validated, doubt),
            effects=named,
            invisible=unseen,
            limits=_not_reported(detection_limits(beside, effects), named),
            unknown=unknown,
            where=places(base, noise),
            fitted=fitted,
            held_out=cross_validated.gap,
            closed=np.nan if cross_validated.closed is None else cross_validated.closed.share,
            closed_gap=cross_validated.closed,
            floor=cross_validated.floor,
            promises=promises,
            next_measurement=self._next(named),
            ranking=self._ranking(seen, decision),
            threshold=self.threshold,
            threshold_from=self.threshold_from,
            signatures=seen,
            classes=classes(seen, unseen),
            rows=cross_validated.rows,
            scatter=_scatter(decision.final),
            outliers=self._outliers,
            notes=(
                *self.ready.notes,
                *remarks(self.measurements, base),
                *map(promise_note, promises),
                *worse(cross_validated.gap, cross_validated.floor),
                *cut_short(base.problem.effort),
                *not_written(
                    self.written.without,
                    self.written.unsolved,
                    unknown_left_away=unknown is not None and not self.written.has_unknown,
                ),
                *written_instead(self.written.replaced, self.written.instead),
                *notes(named, self._outliers, cross_validated.chosen),
                *place_or_time(base, _reported(named), unknown),
                *open_answers(open_still, besides=bool(named) or unknown is not None),
            ),
            model=self.written.model,
            plugins=_plugins(),
            base=self.written.base,
            checks=decision.criticism.results,
            choice_sets=decision.choice_sets,
            not_ruled_out=open_still,
        )

    def _sentence(
        self,
        verdict: Verdict,
        named: Sequence[Named],
        unknown: Unknown | None,
        left_out: _LeftOut,
        doubt: str,
    ) -> str:
        """Return the sentence of the verdict, and that of the checks which failed."""
        unsolved = self.written.unsolved if self.written.without else ""
        said = sentence(verdict, named, unknown, left_out.gap, doubt, left_out.closed, unsolved)
        further = left_out_of_verdict(self._outliers), self.decision.criticism.sentence
        return " ".join(filter(None, [said, *further]))

    @cached_property
    def _outliers(self) -> tuple[str, ...]:
        base = self.outcome.base
        return tuple(condition_name(base.problem, n) for n in self.outcome.outliers)

    @property
    def _enough(self) -> bool:
        return setups(self.ready) >= FEWEST_SETUPS

    @cached_property
    def decision(self) -> Decision:
        """Return the effects named, the unknown term, or both, after the criticism."""
        return Judgement(
            outcome=self.outcome, effects=self.effects, threshold=self.threshold,
            enough=self._enough,
        ).decision()  # fmt: skip

    @cached_property
    def written(self) -> WrittenModel:
        """Return the model that a file has."""
        writer = Writer(outcome=self.outcome, measurements=self.measurements, options=self.options)
        return writer.written(self.decision)

    def _signatures(self, pool: Sequence[Candidate], decision: Decision) -> Signatures:
        """Return the signatures visible above the base model, at the final model's noise."""
        base = self.outcome.base
        solution = weigh(base.linear.data, decision.final.solution.log_sigma)
        chosen = (t.chosen for t in self.outcome.steps if t.chosen is not None)
        sizes = {c.name: c.score.amplitude for c in chosen}
        return signatures(replace(base, solution=solution), forms(pool, {}), sizes)

    def _beside(self, pool: Sequence[Candidate], decision: Decision) -> dict[str, float]:
        """Return the length of each effect's signature beside the effects that are named."""
        some = forms(pool, {})
        lengths = lengths_beside(decision.known, some, decision.final.solution.log_sigma)
        return dict(zip((c.name for c in some), lengths.tolist(), strict=True))

    def _doubt(self, decision: Decision) -> str:
        """Return why these data cannot tell, where nothing is found; empty: they can."""
        if not self._enough:
            return too_few(setups(self.ready))
        criticism = decision.criticism
        if criticism.undecided:
            return criticism.undecided
        if decision.named or decision.unknown is not None:
            return ""
        for asked, judged in zip(decision.choice_sets, decision.answers, strict=True):
            if asked.considered != judged.likeliest and NOTHING not in judged.answers:
                return improbable(asked.considered, judged)
        against = [one for one in criticism.failures if one.consequence != Consequence.REMARK]
        if against:  # what is wrong with the names has no place of its own
            return against[0].sentence
        if scatter := unusual_scatter(decision.final):
            return scatter
        left_out, readings = left_out_readings(self.measurements)
        if left_out > max(FEWEST_OUTLIERS, MOST_OUTLIERS_SHARE * readings):
            return many_left_out(left_out, readings)
        noise = unusual_cell_noise(decision.final)
        if noise is not None and noise.times > EXCESSIVE_SCATTER_RATIO:
            return noisy(noise.name, noise.times)
        best = next((c for c in self.outcome.steps[0].ranking if c.known), None)
        if best is not None and best.ln_bayes_factor > self.threshold + NONPARAMETRIC_MARGIN_LN:
            return refused(best.name)
        return ""

    def _verdict(self, named: Sequence[Named], unknown: Unknown | None, doubt: str) -> Verdict:
        if doubt:
            return "cannot_tell"
        if unknown is not None:
            return "unknown_effect"
        if not named:
            return "nothing_missing"
        if any(n.confusable_with for n in named):
            return "indistinguishable"
        return "effect_named"

    def _left_out(self, pool: Sequence[Candidate], decision: Decision) -> _LeftOut:
        base, final = self.outcome.base, self.written.predicting
        noise = gaps.variance(decision.final)
        where = gaps.cells(base, self.outcome.outliers).within(left_out_rows(base))
        rivals = [c.name for t in self.outcome.steps[:1] for c in t.ranking if c.known][
            :CROSS_VALIDATED_NAMES
        ]
        names = {*rivals, *(c.effect.name for c in decision.named)}
        few = [c for c in pool if c.name in names]
        alike = self.written.not_told_apart
        before, after, chosen = left_out(base, final, few, position_groups(base), alike)
        both = BeforeAfter(gaps.gap(before, noise, where), gaps.gap(after, noise, where))
        floor = gaps.floor(noise, where)
        closed = None if final is base else gaps.closed_gap(both, floor)
        rows = gaps.table(base, final, before, after)
        return _LeftOut(gap=both, closed=closed, floor=floor, chosen=chosen, rows=rows)

    def _next(self, named: Sequence[Named]) -> Next | None:
        """Return the measurement that separates a name best from its alternatives together.

        Each counts by its probability. None where nothing on the menu helps.
        """
        one = next((n for n in named if n.confusable_with), None)
        if one is None:
            return None
        effects: Mapping[str, Effect] = {e.name: e for e in self.effects}
        pairs, chances = list[list[Suspect]](), list[float]()
        for rival in one.confusable_with:
            with suppress(ModelError):  # one that these data cannot show
                pairs.append(self._suspects([effects[one.name], effects[rival]]))
                chances.append(one.probabilities.get(rival, 0.0))
        found = next_measurement(self.outcome.base, pairs, chances)
        helps = found is not None and found.expected >= found.separation + LEAST_GAIN_SIGMA
        return found if helps else None

    def separating(self, between: Sequence[Effect]) -> Next | None:
        """Return the measurement that separates two effects best; None: there is none."""
        return next_measurement(self.outcome.base, [self._suspects(between)])

    def _promises(self) -> tuple[Promise, ...]:
        """Return what was promised of measurements that these data hold, and what is found."""
        known = {**catalogue(), **{one.name: one for one in self.effects}}
        made = [
            one for one in self.options.promised
            if len(one.between) > 1 and all(name in known for name in one.between)
        ]  # fmt: skip
        pairs = [[known[name] for name in one.between] for one in made]
        base = self.outcome.base
        return tuple(
            Promise(one, separated(base, self._suspects(pair)))
            for one, pair in zip(made, pairs, strict=True)
        )

    def _suspects(self, between: Sequence[Effect]) -> list[Suspect]:
        """Return effects at the size found; where none of them was, at one just noticed."""
        ranked = {c.name: c.score for t in self.outcome.steps for c in t.ranking if c.known}
        chosen = {t.chosen.name for t in self.outcome.steps if t.chosen is not None}
        names = [one.name for one in between]
        if chosen.intersection(names) and all(name in ranked for name in names):
            return [
                Suspect(one, dict(score.candidate.values), abs(score.amplitude))
                for one, score in ((e, ranked[e.name]) for e in between)
            ]
        base = self.outcome.base
        pool = forms(candidates(base, between), {})
        if len(pool) < len(between):
            raise ModelError(f"these data cannot show {' and '.join(names)} both")
        lengths = signatures(base, pool, {}).detectability
        return [
            Suspect(one, dict(form.values), min(1.0, COMPARISON_SIGMA / max(length, 1e-9)))
            for one, form, length in zip(between, pool, lengths, strict=True)
        ]

    def _ranking(self, seen: Signatures, decision: Decision) -> tuple[Ranked, ...]:
        """Return the candidates against the base model, and what the noise of curves hides."""
        lengths = dict(zip(seen.names, seen.detectability.tolist(), strict=True))
        first: Sequence[RankedCandidate] = (
            self.outcome.steps[0].ranking if self.outcome.steps else []
        )
        free = decision.free
        if free is not None and _at_usual_size(free):
            others = [c for c in first if c.name != free.name]
            first = sorted([free, *others], key=lambda c: -c.ln_bayes_factor)
        return tuple(
            Ranked(
                name=c.name,
                location=c.score.candidate.location,
                log_bayes=c.ln_bayes_factor,
                size=c.score.amplitude,
                detectability=lengths.get(c.name, c.score.length),
                why_not=_at_usual_size(c),
            )
            for c in first
            if c.score.candidate.location != "outlier"
        )


def _at_usual_size(one: RankedCandidate) -> str:
    """Return at which noise or scatter a term was compared; empty: at the estimated one."""
    if of_images(one):
        return "reported, at the usual noise of curves"
    return "reported, at the usual scatter of set-ups" if of_set_ups(one) else ""


def _not_reported(some: Mapping[str, Said], named: Sequence[Named]) -> dict[str, Said]:
    """Return what is said of effects, without those that are reported."""
    reported = _reported(named)
    return {name: values for name, values in some.items() if name not in reported}


def _reported(named: Sequence[Named]) -> set[str]:
    return {name for one in named for name in (one.name, *one.confusable_with)}


def _named(one: Choice, decision: Decision, final: MixedModelFit) -> Named:
    """Return a name with the values of the fit that is written; its form as the search has it."""
    effect = one.effect
    place = next(i for i, f in enumerate(final.found) if f.effect.name == effect.name)
    found, (share, form) = final.found[place], form_of(decision.known, place)
    reported = of_name(effect.name, decision)
    own = {name: parameters_of(final, place, name) for name in found.values}
    first = next(iter(own))
    return Named(
        name=effect.name, location=effect.location, parameters=own[first],
        by_configuration=own if effect.by_configuration else {},
        configuration=first if effect.by_configuration else "",
        confidence=reported.confidence, probabilities=reported.probabilities,
        confusable_with=reported.confusable_with, or_else=reported.or_else,
        form_share=share, form=form, choices=chosen_values(one, found),
    )  # fmt: skip
