"""From records to the table: each goal with its count and 90 % interval, of shares Wilson's.

Which cases count is as in `benchmarks.hidden_effects.score`: a single name only where the next
effect of the catalogue is 4 sigmas or more from the true signature (else any name of the class is
right); 'unknown' only where the best imitation leaves more than a fifth of d^2.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import binom

from benchmarks.hidden_effects.records import Foretold, Name, Record
from benchmarks.hidden_effects.score import (
    IMITATED,
    OUTSIDE_SEEN,
    STANDS_OUT,
    Z90,
    Row,
    at_least,
    at_most,
    clear,
    coverage,
    exactly,
    is_unknown,
    judged_for_confidence,
    mean_at_most,
    named_in_its_class,
    outside,
)
from benchmarks.worlds.base_parameters import held
from benchmarks.worlds.cases import CATALOGUE_FORM, FAMILIES, MIXED
from benchmarks.worlds.reliability import Told, reliability
from model.discrepancy.answers.choice_set import UNKNOWN

SEEN, SURE = 12.0, 0.9
MEDIAN_S, LATE_S, LONGEST_S = 3.0, 10.0, 20.0
PREDICTED, WORSE, CLOSED, CLOSED_IN_WORST_TENTH = 0.3, 0.02, 0.97, 0.85
# share by which an error of the same prediction may differ: solutions end within a nanometre
ROUNDING = 1e-5


def rows(records: Sequence[Record]) -> list[Row]:
    """Return the table of one method."""
    good = [r for r in records if not r.error.startswith("not made")]
    of = {f: [r for r in good if r.family == f] for f in FAMILIES}
    single = [r for r in of["single"] if r.d >= SEEN]
    pairs = [r for r in of["pair"] if r.d >= SEEN and clear(r)]
    beyond = [r for r in of["outside"] if outside(r)]
    caught = [r for r in beyond if is_unknown(r)]
    found = [r for r in good if r.d >= SEEN and (r.said or is_unknown(r))]
    judged = [r for r in good if judged_for_confidence(r) and (r.family != MIXED or mixed(r))]
    return [
        at_most("nothing hidden: something named", 0.01, of["nothing"], lambda r: bool(r.said)),
        at_most("nothing hidden: 'unknown'", 0.01, of["nothing"], is_unknown),
        at_least("single, d >= 12: exactly right", 0.92, single, right),
        at_least("single, d >= 12: truth in the reported set", 0.99, single,
                 lambda r: r.names[0] in r.reported_set),
        at_least("the same, without what is not ruled out besides", 0.99, single,
                 lambda r: r.names[0] in r.reported),
        mean_at_most("single, d >= 12: mean size of the set", 1.3,
                     [len(r.reported_set) for r in single if r.reported_set]),
        mean_at_most("the same, without what is not ruled out besides", 1.3,
                     [len(r.reported) for r in single if r.reported]),
        at_most("confidently wrong (0.9), all cases", 0.01, judged, confidently_wrong),
        *reliability("named: it is there", _named(judged)),
        at_least("pairs, both d >= 12: exactly both", 0.85, pairs, exactly),
        at_least("pairs: both in the reported set", 0.95, pairs,
                 lambda r: set(r.names) <= r.reported_set),
        at_least("the same, without what is not ruled out besides", 0.95, pairs,
                 lambda r: set(r.names) <= r.reported),
        at_least("outside, d >= 30: 'unknown'", 0.90, beyond, is_unknown),
        at_least("outside, d >= 30: 'unknown' in the reported set", 0.95, beyond,
                 lambda r: UNKNOWN in r.reported_set),
        at_least("the unknown's location", 0.95, caught, located),
        at_least("the unknown's location among those told", 0.95, caught, located_in_set),
        at_most("in the catalogue, d >= 12: 'unknown'", 0.04, [*single, *pairs], is_unknown),
        *_mixed([r for r in of[MIXED] if mixed(r)]),
        *_predicted(found),
        *_closed("left-out gap closed, recomputed, median", found),
        coverage([*of["single"], *of[CATALOGUE_FORM]]),
        _base(good),
        _times([r.cpu_s for r in good if not r.error]),
        at_most("refused or failed", 0.0, good, lambda r: bool(r.error)),
    ]  # fmt: skip


def mixed(r: Record) -> bool:
    """Whether effect and other one can be seen beside each other, and none is imitated."""
    effect, other = r.truth
    imitated = min(r.left_tolerant.values(), default=1.0) <= IMITATED
    return effect.d >= SEEN and other.d >= OUTSIDE_SEEN and clear(r) and not imitated


def _mixed(records: Sequence[Record]) -> list[Row]:
    """An effect (the first that is hidden) beside something that no catalogue has."""
    caught = [r for r in records if is_unknown(r)]
    return [
        at_least("effect and something outside: both, and no more", 0.85, records,
                 lambda r: r.said == r.names[:1] and is_unknown(r)),
        at_least("the same: both in the reported set", 0.95, records,
                 lambda r: {r.names[0], UNKNOWN} <= r.reported_set),
        at_least("the same: 'unknown'", 0.90, records, is_unknown),
        at_least("the same: the unknown's location", 0.95, caught, located),
    ]  # fmt: skip


def right(r: Record) -> bool:
    """Exactly the effect, or one of its class where others look like it."""
    return exactly(r) if clear(r) else named_in_its_class(r)


def located(r: Record) -> bool:
    """Whether the unknown was put where it acts."""
    return r.unknown is not None and r.unknown.slot in r.truth[-1].accepted_slots


def located_in_set(r: Record) -> bool:
    """Whether a place where the unknown acts is among those it may be at."""
    told = set() if r.unknown is None else {r.unknown.slot, *r.unknown.slots}
    return bool(told & {*r.truth[-1].accepted_slots})


def confidently_wrong(r: Record) -> bool:
    """Whether something was named surely that is not there, nor what it may be confused with."""
    outside_catalogue = {"outside": {UNKNOWN}, MIXED: {*r.names[:1], UNKNOWN}}
    there = outside_catalogue.get(r.family) or set(r.names)
    return any(n.confidence >= SURE and not _set(n) & there for n in r.named)


def _named(records: Sequence[Record]) -> list[Told]:
    """Return the confidence of each name, of its class, and whether that is there."""
    return [
        (r.key, n.confidence, r.family != "outside" and bool({n.name, *n.confusable_with} & {
            *r.names}))
        for r in records for n in r.named
    ]  # fmt: skip


def _set(n: Name) -> set[str]:
    return {n.name, *n.confusable_with, *n.or_else}


def _base(records: Sequence[Record]) -> Row:
    """How often the intervals of B and the EIBMs hold the truth; those of a case go together."""
    what, goal, told = "90 % interval of B or an EIBM holds the truth", "88 - 92 %", held(records)
    if not told:
        return Row(what, goal, "-", 0)
    share = sum(one.ok for one in told) / len(told)
    off: dict[str, float] = {}
    for one in told:
        off[one.key] = off.get(one.key, 0.0) + one.ok - share
    reach = Z90 * float(np.sqrt(np.sum(np.square(list(off.values()))))) / len(told)
    interval = f"{share - reach:.1%} - {share + reach:.1%} ({len(off)} cases)"
    failed = [one.key for one in told if not one.ok]
    return Row(what, goal, f"{share:.1%}", len(told), interval, 0.88 <= share <= 0.92, failed)


def _predicted(records: Sequence[Record]) -> list[Row]:
    """Errors at conditions not measured, over the base model's."""
    use = [(r, r.foretold) for r in records if r.foretold is not None]
    gain = [(r, f) for r, f in use if f.least < 1.0 / STANDS_OUT]
    what = "predicted at unmeasured conditions, d >= 12: error over the base model's, median"
    return [
        _ratio(what, [f for _, f in use]),
        at_most("the same: worse than the base model", WORSE, [r for r, _ in use], is_worse),
        _ratio("the same, base model off by twice the floor: median", [f for _, f in gain]),
        at_most("the same: worse than the base model", WORSE, [r for r, _ in gain], is_worse),
    ]


def is_worse(r: Record) -> bool:
    return r.foretold is not None and r.foretold.ratio > 1.0 + ROUNDING


def _ratio(what: str, found: Sequence[Foretold]) -> Row:
    goal = f"<= {PREDICTED:g}"
    if not found:
        return Row(what, goal, "-", 0)
    ratios, least = [f.ratio for f in found], np.median([f.least for f in found])
    low, middle, high = np.percentile(ratios, (25, 50, 75), method="closest_observation")
    interval = f"quartiles {low:.2f}, {high:.2f}; floor {least:.2f}"
    return Row(what, goal, f"{middle:.2f}", len(found), interval, bool(middle <= PREDICTED))


def _closed(what: str, records: Sequence[Record]) -> list[Row]:
    """The share of the excess that is gone at a position that the method was not given."""
    told = [
        (r.key, r.left_out.closed) for r in records
        if r.left_out is not None
        and r.left_out.in_floors(r.left_out.base) > STANDS_OUT * r.left_out.in_floors(
            r.left_out.floor)
    ]  # fmt: skip
    tenth = "the same, worst tenth"
    goal, worst_goal = f">= {CLOSED:.0%}", f">= {CLOSED_IN_WORST_TENTH:.0%}"
    if not told:
        return [Row(what, goal, "-", 0), Row(tenth, worst_goal, "-", 0)]
    values = [v for _, v in told]
    worst, middle = np.percentile(values, (10, 50))
    bad = [key for key, v in told if v < 0.5]
    return [
        Row(what, goal, f"{middle:.1%}", len(told), quantile_interval(values, 0.5),
            bool(middle >= CLOSED), bad),
        Row(tenth, worst_goal, f"{worst:.1%}", len(told), quantile_interval(values, 0.1),
            bool(worst >= CLOSED_IN_WORST_TENTH)),
    ]  # fmt: skip


def quantile_interval(values: Sequence[float], share: float) -> str:
    """Return the 90 % interval of a quantile, by the ranks that it may have (binomial)."""
    ranked, chances = np.sort(values), binom(len(values), share)
    low, high = int(chances.ppf(0.05)), int(chances.ppf(0.95)) + 1  # from 1
    return f"{ranked[max(low, 1) - 1]:.1%} - {ranked[min(high, len(ranked)) - 1]:.1%}"


def _times(seconds: Sequence[float]) -> Row:
    what, goal = "CPU time: median", f"<= {MEDIAN_S:g}, 95 % {LATE_S:g}, longest {LONGEST_S:g} s"
    if not seconds:
        return Row(what, goal, "-", 0)
    median, late = np.quantile(seconds, [0.5, 0.95])
    longest = max(seconds)
    met = median <= MEDIAN_S and late <= LATE_S and longest <= LONGEST_S
    spread = f"95 % below {late:.1f} s, longest {longest:.1f} s"
    return Row(what, goal, f"{median:.1f} s", len(seconds), spread, bool(met))


def compared(by_method: dict[str, list[Record]]) -> str:
    """Return the found values of several methods side by side, as Markdown."""
    tables = {name: rows(found) for name, found in by_method.items()}
    first = next(iter(tables.values()))
    lines = ["| | goal | " + " | ".join(tables) + " |", "|---" * (2 + len(tables)) + "|"]
    for i, row in enumerate(first):
        cells = [f"{t[i].value} of {t[i].count}" if i < len(t) else "-" for t in tables.values()]
        lines.append(f"| {row.what} | {row.goal} | " + " | ".join(cells) + " |")
    return "\n".join(lines)
