"""Make the reported sets of a verdict: alternatives of each name, and of 'unknown'."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

from model.discrepancy.answers.calibrated_answers import Judged, is_name
from model.discrepancy.answers.choice_set import NOTHING, UNKNOWN
from model.discrepancy.thresholds import KEPT_BESIDE_SAME_LOCATION, MANY_NAMES, OVERLOOKED_TOLD
from model.discrepancy.verdict.decision import Decision
from model.discrepancy.verdict.probable_names import beside_strict_form, pieces
from model.discrepancy.verdict.result import Unknown

NO_ANSWER = Judged({}, ())
LEAST_REJECTED = 0.05  # probability of a rejected name, from which on it is not ruled out


@dataclass(frozen=True, kw_only=True)
class ReportedSet:
    """A name with what it may be confused with."""

    confidence: float  # of all names of the set together
    confusable_with: tuple[str, ...]
    or_else: tuple[str, ...]  # answers of the set that are no names
    probabilities: Mapping[str, float]  # of each member of the set


def of_name(name: str, decision: Decision) -> ReportedSet:
    """Return the set of a name that is reported; rivals that a check found are in it."""
    judged = answer_about(name, decision)
    names = dict.fromkeys([name, *judged.names, *decision.criticism.rivals(name)])
    others = [one for one in judged.answers if not is_name(one)]
    overlooked = decision.criticism.overlooked(name)
    # several names may together imitate something that none of them says: what acts at their
    # location, or a strong effect in a form that differs from the catalogue's
    piece = name in pieces(decision.named) or beside_strict_form(name, decision.known.found)
    several = piece or (decision.nonparametric_explains_more and len(decision.named) >= MANY_NAMES)
    doubtful = several or decision.criticism.doubted([name]) or overlooked < OVERLOOKED_TOLD
    doubtful = doubtful or (decision.criticism.incomplete and decision.unknown is None)
    believed = overlooked * (KEPT_BESIDE_SAME_LOCATION if piece else 1.0)
    others += [UNKNOWN] if doubtful else []
    or_else = tuple(dict.fromkeys(others))
    chances = {one: judged.probabilities.get(one, 0.0) for one in (*names, *or_else)}
    chances = shared(chances, {name: 1.0, **decision.criticism.odds(name)})
    if believed < 1.0:  # what somebody should have noticed is something else
        chances[UNKNOWN] = chances.get(UNKNOWN, 0.0) + (1.0 - believed) * chances[name]
        chances[name] *= believed
    return ReportedSet(
        confidence=min(sum(chances[one] for one in names), 1.0),
        confusable_with=tuple(
            sorted((one for one in names if one != name), key=lambda one: -chances[one])
        ),
        or_else=or_else,
        probabilities=chances,
    )


def shared(chances: Mapping[str, float], odds: Mapping[str, float]) -> dict[str, float]:
    """Return probabilities in which names that nothing tells apart have theirs together."""
    each = sum(chances[one] for one in odds) / sum(odds.values())
    return {**chances, **{one: each * share for one, share in odds.items()}}


def with_alternatives(unknown: Unknown, decision: Decision) -> Unknown:
    """Return what is unknown with the names that it may be all the same.

    Those of the questions whose names were rejected, and of the one about the rest.
    """
    reported = {one.effect.name for one in decision.named}
    chances: dict[str, float] = {UNKNOWN: 0.0}
    for asked, judged in zip(decision.choice_sets, decision.answers, strict=True):
        if asked.considered in reported:
            continue
        for name in (UNKNOWN, *judged.names):
            if name not in reported:
                chances[name] = max(chances.get(name, 0.0), judged.probabilities[name])
    others = sorted((n for n in chances if n != UNKNOWN), key=lambda n: -chances[n])
    return replace(unknown, confusable_with=tuple(others), probabilities=chances)


def not_ruled_out(decision: Decision, reported: Collection[str]) -> dict[str, float]:
    """Return what may be there, too, or although nothing is reported, with its probability.

    The answers to questions of something unknown that is reported are told with it: see
    `with_alternatives`.
    """
    chances, answered = dict[str, float](), set[str]()
    if decision.unknown is not None:
        chances |= {n: p for n, p in decision.hidden.items() if n not in reported}
        return chances
    for asked, judged in zip(decision.choice_sets, decision.answers, strict=True):
        if asked.considered in reported:
            continue
        answers = dict.fromkeys(judged.answers)
        answered |= set(judged.answers)
        # a name that a check rejected
        if judged.probabilities.get(asked.considered, 0.0) >= LEAST_REJECTED:
            answers[asked.considered] = None
        for name in answers:
            if name != NOTHING and name not in reported:
                chances[name] = max(chances.get(name, 0.0), judged.probabilities[name])
    for name, chance in decision.hidden.items():
        if name not in {*reported, *answered}:  # the answer to a question knows more
            chances[name] = max(chances.get(name, 0.0), chance)
    return dict(sorted(chances.items(), key=lambda one: -one[1]))


def answer_about(considered: str, decision: Decision) -> Judged:
    """Return the judged answers to the question that the search answers so; or an empty one."""
    pairs = zip(decision.choice_sets, decision.answers, strict=True)
    return next((judged for asked, judged in pairs if asked.considered == considered), NO_ANSWER)
