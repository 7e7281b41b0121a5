"""Sentences for verdicts and notes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from model.discrepancy.answers.calibrated_answers import Judged
from model.discrepancy.answers.choice_set import NOTHING, UNKNOWN
from model.discrepancy.criticism.cell_noise import CELL
from model.discrepancy.thresholds import FEWEST_SETUPS, REPORTED_FORM_SHARE, REPORTED_GAP_RATIO
from model.discrepancy.verdict.result import (
    BeforeAfter,
    ClosedGap,
    Gap,
    Named,
    Promise,
    Unknown,
    Verdict,
)
from model.effects import catalogue, title
from model.effects.between_sessions import session_of
from model.identification.likelihood.effort import Effort
from model.measurements import in_decimals
from model.parameter import Parameter

DIFFERS = {
    "stiffness": "the sheet's stiffness", "eibm": "the EIBM", "position": "the place on the arc",
    "force_zero": "the load cell's zero", "clamp_tilt": "the direction at the clamp",
    "registration": "the place in the picture",
}  # fmt: skip

MOST_TOLD = 4  # names in a sentence; the table of probabilities has all
EVEN_SHARE = 1e-6  # of a profile's size: what it varies less is the same everywhere
OTHER_ANSWERS = {
    UNKNOWN: "something that is not in the catalogue", NOTHING: "nothing of the kind",
}  # fmt: skip


def shown_by(names: Sequence[str]) -> str:
    """Return a sentence about what shows each of some effects, whether it is on the menu or not."""
    known = catalogue()
    each = (f"{title(name)}: {known[name].isolates.rstrip('.')}" for name in names if name in known)
    which = "it" if len(names) == 1 else "each of them"
    return f"What shows {which} by itself: {'; '.join(each)}."


def nothing_separates(names: Sequence[str]) -> str:
    """Return sentences for effects that no measurement on the menu tells apart."""
    both = " from ".join(map(title, names))
    return f"Nothing on the menu would tell {both}. {shown_by(names)}"


def sentence(
    verdict: Verdict,
    named: Sequence[Named],
    unknown: Unknown | None,
    left_out: BeforeAfter,
    doubt: str,
    closed: ClosedGap | None = None,
    unsolved: str = "",
) -> str:
    """Return the verdict in sentences; `doubt` says why the data do not allow one.

    `closed` is the gap that is closed on left-out positions; None: none stands out of the noise.
    `unsolved`: where the model with what was found has no solution, if the file has the base model
    for that.
    """
    if verdict == "cannot_tell":
        return f"These data do not allow a verdict: {doubt}."
    if verdict == "nothing_missing":
        return "Nothing is seen that is not in the model: what is left is noise and scatter."
    if unknown is not None:
        return _unknown_sentence(named, unknown, left_out, closed)
    is_not = "are not" if len(named) > 1 else "is not"
    names = listed([class_name(n) for n in named])
    values = "".join(
        f" {_capital(title(one.name))}: {in_sessions(one)}." for one in named if in_sessions(one)
    )
    text = f"{_capital(names)} {is_not} in the model.{values}"
    if unsolved:
        return f"{text} The model with it has no solution at {unsolved}: it predicts nothing."
    text = f"{text} {_gap(left_out)}."
    return text if closed is None else f"{text} {closed_sentence(closed)}"


def _unknown_sentence(
    named: Sequence[Named], unknown: Unknown, left_out: BeforeAfter, closed: ClosedGap | None
) -> str:
    """Return where something unknown acts, what else it may be, and what its curve predicts."""
    more = f" besides {listed([class_name(n) for n in named])}" if named else ""
    text = f"An unknown effect{more} is in neither the model nor the catalogue."
    if unknown.confusable_with:
        names = listed([title(name) for name in unknown.confusable_with], "or")
        text = (
            f"Something{more} is not in the model; it may be {names}, or {OTHER_ANSWERS[UNKNOWN]}."
        )
    text += (
        f" Location: {located(unknown)} ({unknown.depends}); {_largest(unknown)}."
        f"{_or_elsewhere(unknown)}"
    )
    text += f" {_gap(left_out)}."
    if closed is not None and closed.after >= closed.before:
        text += " The curve does not improve the prediction between the positions."
    elif closed is not None:
        text += f" {closed_sentence(closed)}"
    return f"{text} {unknown.advice}".rstrip()


def _largest(unknown: Unknown) -> str:
    """Return where its profile is largest, or its size where that is the same everywhere."""
    largest = np.max(np.abs(unknown.profile))
    if largest > 0.0 and np.ptp(unknown.profile) < EVEN_SHARE * largest:
        return f"its size is {unknown.profile[0]:.2g} ({unknown.unit})"
    return f"largest at {unknown.peak_mm:.3g} {unknown.at_unit}"


def located(unknown: Unknown) -> str:
    """Return the location of something unknown, with its share where there are others."""
    name = title(unknown.location)
    share = unknown.locations.get(unknown.location)
    return f"{name}, {percent(share)}" if share and unknown.other_locations else name


def _or_elsewhere(unknown: Unknown) -> str:
    """Return the other locations that explain the data about as well; empty: there are none."""
    others = [f"{title(name)}, {percent(p)}" for name, p in
              unknown.other_locations.items()]  # fmt: skip
    return f" It may act elsewhere: {listed(others, 'or')}." if others else ""


def class_name(one: Named) -> str:
    """Return the name of an effect, or the answers of its set, names with their probability."""
    answers = [
        *shortened([title(name) for name in (one.name, *one.confusable_with)]),
        *map(answer_title, one.or_else),
    ]
    if len(answers) == 1:
        return answers[0]
    names = " or ".join(answers)
    if not one.confusable_with:
        return f"{names} ({percent(one.confidence)} that it is {answers[0]})"
    what = "together" if not one.or_else else "the names together"
    return f"{names} (which these data cannot tell apart; {what} {percent(one.confidence)})"


def improbable(considered: str, judged: Judged) -> str:
    """Return why what the search names, or does not name, is not reported."""
    answers = [answer_title(name) for name in judged.answers]
    if considered in (UNKNOWN, NOTHING):
        return f"little speaks for anything, but it may be {' or '.join(answers)}"
    own = percent(judged.probabilities.get(considered, 0.0))
    return (
        f"{title(considered)} explains most, but with a probability of only {own}; it may be"
        f" {' or '.join(answers)}"
    )


def open_answers(others: Mapping[str, float], *, besides: bool) -> Iterator[str]:
    """Yield what may be in the data beside what is reported, or although nothing is."""
    if others:
        each = (f"{answer_title(name)} ({percent(chance)})" for name, chance in others.items())
        yield f"not ruled out{' besides' * besides}: {', '.join(each)}"


def answer_title(name: str) -> str:
    """Return an effect's title, or what is said of something unknown and of nothing."""
    return OTHER_ANSWERS.get(name) or title(name)


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def in_sessions(one: Named) -> str:
    """Return an effect's values in each session with their 90 % intervals; empty: it has none."""
    sheets = one.by_configuration or {"": one.parameters}
    return "; ".join(
        f"{name}{': ' * bool(name)}{values}"
        for name, own in sheets.items()
        if (values := _values(own))
    )


def _values(parameters: Mapping[str, Parameter]) -> str:
    own = {session_of(name): p for name, p in parameters.items() if session_of(name)}
    less = " less session 1" if own and 1 not in own else ""
    return ", ".join(f"session {number}{less} {_with_interval(p)}" for number, p in own.items())


def _with_interval(parameter: Parameter) -> str:
    p = parameter if parameter.unit else parameter.scaled(100.0, "%")
    low, high = p.interval()
    return f"{p.value:+.3g} {p.unit} ({low:+.3g} to {high:+.3g})"


def percent(share: float) -> str:
    """Return a probability or share in whole percent, never rounded to all or nothing."""
    if share >= 0.995:
        return "more than 99 %"
    return "less than 1 %" if share < 0.005 else f"{100 * share:.0f} %"


def closed_sentence(one: ClosedGap) -> str:
    """Return the share of a gap that is closed, with the errors that it is made of."""
    digits = 2 if one.unit == "times the noise" else 4 if "along a run" in one.quantity else 3
    before, after, floor = (f"{v:.{digits}f}" for v in (one.before, one.after, one.floor))
    return (
        f"Gap closed above the noise floor: {percent(one.share)} of {one.quantity}"
        f" ({before} → {after} {one.unit}, floor {floor})."
    )


def worse(left_out: BeforeAfter, least: Gap) -> Iterator[str]:
    """Yield what the model with what was found predicts worse than the base model, beyond noise."""
    for name, quantity in (("force_rmse_mN", "force"), ("curve_rmse_mm", "neutral curve")):
        before, after, noise = (getattr(g, name) for g in (left_out.before, left_out.after, least))
        if after > REPORTED_GAP_RATIO * max(before, noise):
            yield (
                f"the {quantity} at left-out positions is predicted worse than by the base model;"
                " do not predict it with this model"
            )


def written_instead(name: str, instead: str) -> Iterator[str]:
    """Yield why the model file has another effect than the one that is named, where it has."""
    if instead:
        yield (
            f"the model file has {title(instead)} instead of {title(name)}: these data do not tell"
            f" them apart, but the curves are rather as long as with {title(instead)}"
        )


def not_written(
    left_away: bool, unsolved: str = "", *, unknown_left_away: bool = False
) -> Iterator[str]:
    """Yield why the model file has only a part of what was found, or nothing of it.

    `unsolved` is where the model with all of it has no solution; `unknown_left_away` whether what
    is unknown is in no model.
    """
    if unsolved:
        kept = "has the base model without it" if left_away else "leaves that form out"
        yield (
            f"with the form that was inferred the model has no solution at {unsolved}: the model"
            f" file {kept}"
        )
    elif left_away:
        yield (
            "what was found does not improve the prediction of mean forces and curves at left-out"
            " positions: the model file has the base model without it"
        )
    elif unknown_left_away:
        yield (
            "the model file has nothing of what is unknown: these data do not show that it improves"
            " a prediction"
        )


def promise_note(one: Promise) -> str:
    """Return what a proposed measurement promised, and what was found with it."""
    names = listed([title(name) for name in one.proposal.between])
    return (
        f"measured as proposed ({one.proposal.extra.replace('_', ' ')}): {names} were"
        f" {one.proposal.separation:.1f} sigma apart; promised {one.proposal.expected:.1f},"
        f" found {one.found:.1f}"
    )


def shortened(names: Sequence[str]) -> list[str]:
    """Return the first of many names, and how many others there are; a few as they are."""
    if len(names) <= MOST_TOLD:
        return list(names)
    return [*names[: MOST_TOLD - 1], f"{len(names) - MOST_TOLD + 1} others"]


def listed(names: Sequence[str], last: str = "and") -> str:
    """Return names as English has them: a, b and c."""
    return f" {last} ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))


def too_few(setups: int) -> str:
    """Return the message that there are too few set-ups."""
    there = {0: "there is no set-up", 1: "there is one set-up"}.get(
        setups, f"there are {setups} set-ups"
    )
    return (
        f"{there} of the load cell, too few to estimate the scatter between"
        f" set-ups; measure at least {FEWEST_SETUPS} positions, or repeat three of them"
    )


def noisy(name: str, times: float) -> str:
    """Return why noise of the load cell that is larger than usual allows no verdict."""
    return (
        f"the {CELL[name]} is {times:.0f} times the usual one, so that a missing force may hide"
        " in it"
    )


def many_left_out(count: int, of: int) -> str:
    """Return why readings that are far from the others allow no verdict."""
    return (
        f"{count} of {of} readings are far from the others of their condition and were left out,"
        " too many for chance; something acts on single readings, such as a contact that opens or"
        " a disturbance of the load cell: look at their signals"
    )


def scattered(name: str, times: float, follows: tuple[str, float] | None) -> str:
    """Return the message that set-ups differ too much, and what they follow with a correlation."""
    differs = f"{DIFFERS[name]} differs from set-up to set-up {times:.0f} times as much as usual"
    if follows is None:
        return f"{differs}; repeat three positions to see whether that is chance"
    what, correlation = follows
    return (
        f"{differs}, and follows {what} (correlation {correlation:.2f}); that is no chance:"
        f" something that goes with {what} is missing"
    )


def refused(name: str) -> str:
    """Return why an effect that explains something is not named."""
    return (
        f"{title(name)} explains part of the residual, but not on left-out positions, or only in a"
        " form that is not its own"
    )


def _gap(left_out: BeforeAfter) -> str:
    """Return the errors on left-out positions, of the base model and of the final one."""
    before, after = left_out.before, left_out.after
    means = [
        (what, old, new, unit)
        for what, old, new, unit in (
            ("force", before.force_rmse_mN, after.force_rmse_mN, "mN"),
            ("neutral curve", before.curve_rmse_mm, after.curve_rmse_mm, "mm"),
        )
        if math.isfinite(old) and math.isfinite(new)
    ]
    changes = [
        f"{what} {in_decimals(old, 3)} → {in_decimals(new, 3)} {unit}"
        for what, old, new, unit in means
    ]
    old, new = (math.sqrt(g.chi2_per_dof) for g in (before, after))
    if old > REPORTED_GAP_RATIO * new and not any(
        one > REPORTED_GAP_RATIO * other for _, one, other, _ in means
    ):
        changes.append(f"{old:.2f} → {new:.2f} times the noise")  # it is in fine shapes
    changes += [
        f"{what} {in_decimals(old, digits)} → {in_decimals(new, digits)} {unit}"
        for what, old, new, unit, digits in (
            ("force along a run", before.drift_rmse_mN, after.drift_rmse_mN, "mN", 3),
            ("neutral curve along a run", before.drift_rmse_mm, after.drift_rmse_mm, "mm", 4),
            ("force within a pulse", before.pulse_rmse_mN, after.pulse_rmse_mN, "mN", 3),
        )
        if old > REPORTED_GAP_RATIO * new
    ]
    if not changes:
        return "No position can be left out, so the prediction error is not known"
    return f"Prediction error on left-out positions (RMS), before → after: {', '.join(changes)}"


def cut_short(effort: Effort) -> Iterator[str]:
    """Yield what was not tried."""
    if effort.cut_short:
        yield (
            f"the search ended after {effort.most:g} solutions of the model: further effects, or"
            " other beginnings of fits, were not tried, so more may be missing than is told;"
            " --most-effects (most_effects) goes on"
        )


def left_out_of_verdict(outliers: Sequence[str]) -> str:
    """Return the sentence of conditions that nothing explains; empty: there are none."""
    if not outliers:
        return ""
    left_out = "One condition was" if len(outliers) == 1 else f"{len(outliers)} conditions were"
    them = "it" if len(outliers) == 1 else "them"
    return f"{left_out} left out, as nothing explains {them}: {'; '.join(shortened(outliers))}."


def notes(named: Sequence[Named], outliers: Sequence[str], chosen: Sequence[str]) -> Iterator[str]:
    """Yield further notes; `chosen` is the best name with each position left out."""
    if outliers:
        yield f"outliers, left out: {'; '.join(outliers)}"
    other = sorted({c for c in chosen if c} - {n.name for n in named})
    if named and other:
        times = sum(c in other for c in chosen)
        yield (
            f"without one of the positions, {', '.join(map(title, other))} is chosen in {times} of"
            f" {len(chosen)} cases"
        )
    for n in named:
        if n.form_share > REPORTED_FORM_SHARE:
            yield (
                f"{title(n.name)}: the form differs from the catalogue's; the kind of effect is"
                " found, not its formula"
            )
