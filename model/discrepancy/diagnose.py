"""`diagnose`: from measurements to what the model is missing."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy import gaps
from model.discrepancy.decide import LEFT, SLOT_MARGIN, Choice, Leftover, choices, leftover
from model.discrepancy.menu import next_measurement as from_menu
from model.discrepancy.nulls import DEFAULT, null_gains, threshold
from model.discrepancy.outliers import condition_name
from model.discrepancy.prepare import FEWEST_SETUPS, Options, Prepared, prepare, setups
from model.discrepancy.profile import form_of, unknown_effect, unknown_of, with_free_form
from model.discrepancy.result import (
    BeforeAfter,
    Diagnosis,
    Named,
    Next,
    Ranked,
    Signatures,
    Unknown,
    Verdict,
)
from model.discrepancy.scatter import ASSUMED
from model.discrepancy.score import candidates
from model.discrepancy.search import Contender, Outcome, search
from model.discrepancy.settle import Fitted
from model.discrepancy.signatures import class_of, classes, forms, invisible, signatures
from model.discrepancy.slots import unknowns
from model.discrepancy.tolerance import Found
from model.effects.catalogue import catalogue
from model.effects.interface import Effect
from model.measurements import Measurements, ModelError
from model.noise import weigh
from model.parameter import Parameter
from model.setup import ActiveEffect
from model.sheet_model import Along, ConfiguredSheet, SheetModel

Progress = Callable[[str, float], None]
FEW = 12.0  # degrees of freedom of the intervals: there are about so many set-ups


def diagnose(
    measurements: Measurements, options: Options | None = None, progress: Progress | None = None
) -> Diagnosis:
    """Find what the base model is missing; a `ModelError` where it cannot even be fitted."""
    began = time.perf_counter()
    options = options or Options()
    say = progress or (lambda what, share: None)
    say("fitting the base model", 0.0)
    ready = prepare(measurements, options)
    effects = _effects(options)
    say("searching", 0.2)
    enough = setups(ready) >= FEWEST_SETUPS
    limit, limit_from = DEFAULT, "the built-in value"
    if not enough:
        limit, limit_from = np.inf, "nothing is named: too few set-ups"
    outcome = search(ready.problem, ready.theta, effects, limit, options.most_effects, ready.found)
    if options.calibrate and enough:
        pool = [*candidates(outcome.base, effects), *unknowns(outcome.base)]
        gains = null_gains(outcome.base, pool, options.calibrate, options.seed, progress)
        limit = threshold(gains)
        limit_from = f"{options.calibrate} simulated sessions with nothing missing"
        outcome = search(
            ready.problem, ready.theta, effects, limit, options.most_effects, ready.found
        )
    say("judging", 0.8)
    found = _Finding(ready, outcome, effects, limit, limit_from, enough)
    result = found.diagnosis(measurements, options)
    say("done", 1.0)
    return replace(result, seconds=time.perf_counter() - began)


def next_measurement(
    measurements: Measurements, between: tuple[str, ...], options: Options | None = None
) -> Next:
    """What to measure to tell effects apart; a `ModelError` where nothing on the menu does."""
    from model.effects.catalogue import effect

    ready = prepare(measurements, options or Options())
    chosen = [effect(name) for name in between]
    if len(chosen) < 2:
        raise ModelError("name two effects to be told apart, for example gravity and clamp_angle")
    fitted = search(ready.problem, ready.theta, [], np.inf).base
    pool = forms(candidates(fitted, chosen), {})
    lengths = signatures(fitted, pool, {}).detectability
    sizes = [min(1.0, 8.0 / max(x, 1e-9)) for x in lengths]
    found = from_menu(fitted, chosen, [dict(c.values) for c in pool], sizes)
    if found is None or found.expected <= found.separation * 1.01:
        raise ModelError(f"nothing on the menu would tell {' from '.join(between)}")
    return found


def _effects(options: Options) -> list[Effect]:
    every = catalogue()
    unknown = [name for name in options.exclude if name not in every]
    if unknown:
        raise ModelError(f"there is no effect called '{unknown[0]}'; `labrig effects` lists them")
    skip = set(options.exclude)
    if not options.symmetric:
        skip.add("eibm_asymmetry")  # a parameter of the base model then, not a finding
    return [e for name, e in every.items() if name not in skip]


@dataclass
class _Finding:
    ready: Prepared
    outcome: Outcome
    effects: list[Effect]
    limit: float
    limit_from: str
    enough: bool

    def diagnosis(self, measurements: Measurements, options: Options) -> Diagnosis:
        base = self.outcome.base
        named, final = choices(self.outcome, self.effects, self.limit)
        rest = leftover(self.outcome, final, self.effects)
        unknown = self._unknown(rest, final)
        if unknown is not None and rest is not None and self._alone(rest, final):
            named, final = [], base
        final_known = final
        if unknown is not None and rest is not None:
            free = rest.first if final is base else rest.last
            final = with_free_form(final, free or rest.first)
        pool = candidates(base, self.effects)
        sizes = self._amplitudes()
        # what could be seen is asked with the noise as it is once the finding is in
        known = weigh(base.linear.data, final.solution.log_sigma)
        judge = replace(base, solution=known)
        seen = signatures(judge, forms(pool, {}), sizes)
        unseen = invisible(base, seen, {e.name: e for e in self.effects})
        results = tuple(self._named(i, c, final_known, seen) for i, c in enumerate(named))
        results = self._known(results)
        verdict = self._verdict(results, unknown)
        where = gaps.cells(base)
        noise = gaps.variance(final)
        best = [c for t in self.outcome.turns[:1] for c in t.ranking if c.known]
        names = {c.name for c in best[:6]} | {f.effect.name for f in final.found}
        few = [c for c in pool if c.name in names]
        before, after, chosen = gaps.left_out(base, final, few, gaps.position_groups(base))
        fitted = BeforeAfter(
            gaps.gap(gaps.refitted(base), noise, where),
            gaps.gap(gaps.refitted(final), noise, where),
        )
        held = BeforeAfter(gaps.gap(before, noise, where), gaps.gap(after, noise, where))
        closed = np.nan if final is base else gaps.closed_share(held, gaps.floor(noise, where))
        after_that = self._next(results, base)
        model = self._model(final_known, unknown, measurements, fitted, options)
        return Diagnosis(
            verdict, self._sentence(verdict, results, unknown, held), results, unseen, unknown,
            gaps.places(base, noise), fitted, held, closed, after_that, self._ranking(seen), self.limit,
            self.limit_from, seen, classes(seen, unseen),
            gaps.table(base, final, before, after),
            dict(zip(ASSUMED, np.exp(base.solution.log_sigma).tolist(), strict=False)),
            tuple(condition_name(base.problem, n) for n in self.outcome.outliers),
            self._notes(results, chosen, final_known), model, base=_base_parameters(final_known),
        )  # fmt: skip

    # -- parts

    def _unknown(self, rest: Leftover | None, final: Fitted) -> Unknown | None:
        if rest is None or not self.enough:
            return None
        if rest.gain < self.limit + SLOT_MARGIN or rest.share < LEFT:
            return None
        if self._alone(rest, final) or rest.last is None:
            return unknown_of(self.outcome.base, rest.first)
        return unknown_of(final, rest.last)

    def _alone(self, rest: Leftover, final: Fitted) -> bool:
        """Whether one free form explains more than all the names together."""
        explained = 0.5 * (self.outcome.base.deviance - final.deviance) if final.found else 0.0
        return rest.first.gain * (1.0 - LEFT) > explained + SLOT_MARGIN

    def _amplitudes(self) -> dict[str, float]:
        result = {}
        for turn in self.outcome.turns:
            if turn.chosen is not None:
                result[turn.chosen.name] = turn.chosen.score.amplitude
        return result

    def _named(self, i: int, one: Choice, final: Fitted, seen: Signatures) -> Named:
        share, form = form_of(final, i)
        near = class_of(one.effect.name, seen)
        others = dict(one.alternatives)
        confusable = tuple(n for n in others if others[n] > 0.05 or n in near)
        found = final.found[i]
        freedom = FEW
        own = {name: _parameters(found, name, final, freedom) for name in found.values}
        shared = next(iter(own.values()))
        return Named(
            one.effect.name, one.effect.slot, shared,
            own if one.effect.by_configuration else {}, one.confidence, confusable, share, form,
        )  # fmt: skip

    def _known(self, named: tuple[Named, ...]) -> tuple[Named, ...]:
        """Effects that the given model had already are not findings."""
        given = {f.effect.name for f in self.ready.found}
        return tuple(n for n in named if n.name not in given)

    def _verdict(self, named: tuple[Named, ...], unknown: Unknown | None) -> Verdict:
        if not self.enough:
            return "cannot_tell"
        if unknown is not None:
            return "unknown_effect"
        if not named:
            return "nothing_missing"
        if any(n.confusable_with and n.confidence < 0.8 for n in named):
            return "indistinguishable"
        return "effect_named"

    def _sentence(
        self, verdict: Verdict, named: tuple[Named, ...], unknown: Unknown | None, held: BeforeAfter
    ) -> str:
        if verdict == "cannot_tell":
            return (
                f"These data cannot tell what is missing: there are {setups(self.ready)} set-ups of the"
                f" load cell, too few to know how much one set-up differs from the next; measure at"
                f" least {FEWEST_SETUPS} positions, or set three of them anew."
            )
        before, after = held.before, held.after
        gap = (
            f"the gap on left-out positions goes from {before.force_rmse_mN:.3f} to"
            f" {after.force_rmse_mN:.3f} mN and from {before.curve_rmse_mm:.3f} to"
            f" {after.curve_rmse_mm:.3f} mm"
        )
        names = " and ".join(n.name for n in named)
        if verdict == "nothing_missing":
            return (
                "Nothing is missing that these data could show: what is left is noise and scatter."
            )
        if unknown is not None:
            more = f", beside {names}," if named else ""
            return (
                f"Something is missing{more} that is none of the known effects: it acts on"
                f" {unknown.slot.replace('_', ' ')}, {unknown.depends}, most of all at"
                f" {unknown.peak_mm:.0f} {'mm' if unknown.along != 'time' else 's'}."
            )
        if verdict == "indistinguishable":
            also = sorted({c for n in named for c in n.confusable_with})
            return f"{names} is missing, or {' or '.join(also)}, which these data cannot tell apart; {gap}."
        plural = "are" if len(named) > 1 else "is"
        return f"{names} {plural} missing: with it {gap}."

    def _next(self, named: tuple[Named, ...], base: Fitted) -> Next | None:
        pair = next(((n.name, n.confusable_with[0]) for n in named if n.confusable_with), None)
        if pair is None:
            return None
        by_name = {e.name: e for e in self.effects}
        if any(p not in by_name for p in pair):
            return None
        contenders = {c.name: c for t in self.outcome.turns for c in t.ranking if c.known}
        both = [contenders[p].score for p in pair if p in contenders]
        if len(both) < 2:
            return None
        return from_menu(
            base, [by_name[p] for p in pair], [dict(s.candidate.values) for s in both],
            [abs(s.amplitude) for s in both],
        )  # fmt: skip

    def _ranking(self, seen: Signatures) -> tuple[Ranked, ...]:
        lengths = dict(zip(seen.names, seen.detectability.tolist(), strict=True))
        turn: Sequence[Contender] = self.outcome.turns[0].ranking if self.outcome.turns else []
        return tuple(
            Ranked(
                c.name, c.score.candidate.slot, c.gain, c.score.amplitude,
                lengths.get(c.name, c.score.length),
            )
            for c in turn if c.score.candidate.slot != "outlier"
        )  # fmt: skip

    def _notes(self, named: tuple[Named, ...], chosen: list[str], final: Fitted) -> tuple[str, ...]:
        notes = list(self.ready.notes)
        if self.outcome.outliers:
            names = ", ".join(condition_name(final.problem, n) for n in self.outcome.outliers)
            notes.append(f"left out, since nothing else is like it: {names}")
        if named and final.found:
            other = sorted({c for c in chosen if c and c != final.found[0].effect.name})
            if other:
                notes.append(
                    f"with a position left out, {', '.join(other)} was chosen"
                    f" {sum(c in other for c in chosen)} of {len(chosen)} times"
                )
        for n in named:
            if n.form_share > 0.5:
                notes.append(
                    f"{n.name}: its form differs from the catalogue's; take the family, not the formula"
                )
        return tuple(notes)

    def _model(
        self, final: Fitted, unknown: Unknown | None, measurements: Measurements,
        fitted: BeforeAfter, options: Options,
    ) -> SheetModel:  # fmt: skip
        """The model with what was found, ready for the next job."""
        study, sheets = final.problem.study, {}
        for c, name in enumerate(study.names):
            sheets[name] = _sheet(final, c)
        effects = [
            ActiveEffect(
                f.effect.name,
                {} if f.effect.by_configuration else _parameters(f, next(iter(f.values)), final, FEW),
                {n: _parameters(f, n, final, FEW) for n in f.values}
                if f.effect.by_configuration else {},
            )
            for f in final.found
        ]  # fmt: skip
        if unknown is not None:
            effects.append(unknown_effect(unknown))
        merit = {
            "force_rmse_N": fitted.after.force_rmse_mN * 1e-3,
            "curve_rmse_m": fitted.after.curve_rmse_mm * 1e-3,
        }
        held = tuple(f"{name or 'all'}, {at * 1e3:g} mm" for name, at in options.hold_out)
        return SheetModel(
            sheets, tuple(effects), measurements.source, measurements.checksum, held,
            {k: v for k, v in merit.items() if np.isfinite(v)},
        )  # fmt: skip


def _parameters(
    one: Found, configuration: str, final: Fitted, freedom: float
) -> dict[str, Parameter]:
    """An effect's values with their uncertainty, derived ones included."""
    values = dict(one.values[configuration])
    sigma = one.sigma.get(configuration, {})
    result = {
        k.name: Parameter(values[k.name], sigma.get(k.name, 0.0), k.unit, freedom)
        for k in one.effect.knobs
    }
    sheet = next(
        look.sheet
        for look in final.problem.study.looks
        if look.sheet.configuration == configuration
    )
    derived = one.effect.derived(values, sheet)
    size = one.effect.size.name
    h = 0.01 * abs(values[size]) or 1e-9
    moved = one.effect.derived({**values, size: values[size] + h}, sheet)
    for name, value in derived.items():
        slope = (moved[name] - value) / h
        unit = one.effect.extra.get(name, "")
        result[name] = Parameter(value, abs(slope) * sigma.get(size, 0.0), unit, freedom)
    return result


def _sheet(final: Fitted, c: int) -> ConfiguredSheet:
    study, part = final.problem.study, final.problem.bases.parts[c]
    scene, theta = study.scenes[c], final.theta
    sigma = np.sqrt(np.maximum(np.diag(final.solution.covariance), 0.0))
    B = float(np.exp(theta[part.stiffness]))
    stiffness = Parameter(B, B * float(sigma[part.stiffness]), "N m^2", FEW)
    rest = scene.rest(scene.s_m)
    for i, row in part.rest.items():
        rest = rest + theta[i] * row
    stated = scene.sheet.initial_curvature
    if stated is not None:
        along = Along(stated[0], stated[1], np.zeros(len(stated[0])), "1/m")
    else:
        along = Along(scene.s_m, rest, np.zeros(len(rest)), "1/m")
    eibm = {
        v: Along.constant(
            Parameter(
                sign * B * float(theta[i]), abs(B * float(theta[i])) * float(
                    np.hypot(sigma[part.stiffness], sigma[i] / max(abs(theta[i]), 1e-9))
                ), "N m", FEW,
            )
        )
        for v, (i, sign) in part.eibm.items()
    }  # fmt: skip
    geometry = replace(scene.sheet, initial_curvature=(along.s_m, along.values))
    return ConfiguredSheet(geometry, stiffness, along, eibm)


def _base_parameters(final: Fitted) -> dict[str, dict[str, Parameter]]:
    result = {}
    for c, name in enumerate(final.problem.study.names):
        sheet = _sheet(final, c)
        own = {"B_Nm2": sheet.B}
        for volts, along in sorted(sheet.eibm.items()):
            own[f"EIBM {volts:+g} V"] = Parameter(
                float(along.values[0]), float(along.sigma[0]), "N m", FEW
            )
        result[name] = own
    return result
