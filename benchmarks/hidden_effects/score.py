"""From records to the table: each goal with its count and Wilson interval, and the cases that fail.

An effect counts as single only where the next effect of the catalogue is `APART` sigmas or more
from its true signature; closer ones form a class, and any name of the class is right. An effect
that no catalogue has counts as unknown only where the best imitation, its form tolerated, leaves
more than `IMITATED` of d^2. See `visible` for how these are measured.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from benchmarks.hidden_effects.records import Record

APART, SEEN, NOT_SEEN, OUTSIDE_SEEN = 4.0, 8.0, 4.0, 30.0
IMITATED = 0.2
SURE = 0.95
REALISTIC_MN = (0.17, 0.7)  # 0.2 to 0.6, within the tolerance of a size
THIRTY = (20.0, 45.0)
STANDS_OUT = 2.0  # chi^2 per number on left-out positions from which there is a gap to close
WITHIN_MM, WIDEST_MM = 10.0, 30.0
ON_ONE_SHEET = {"initial_curvature": "long", "surface_tension": "short"}  # as they are hidden
SINGLE = ("own_form", "other_form", "realistic")
Z90 = 1.6449


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    what: str
    goal: str
    value: str
    count: int
    interval: str = ""
    met: bool | None = None  # None: nothing to judge by
    failed: list[str] = field(default_factory=list)  # keys


def wilson(hits: int, count: int, z: float = Z90) -> tuple[float, float]:
    """The 90 % interval of a share."""
    if not count:
        return 0.0, 1.0
    share, square = hits / count, z**2
    centre = (share + square / (2 * count)) / (1 + square / count)
    reach = (
        z / (1 + square / count) * math.sqrt(share * (1 - share) / count + square / (4 * count**2))
    )
    return max(0.0, centre - reach), min(1.0, centre + reach)


def at_least(
    what: str, least: float, records: Iterable[Record], right: Callable[[Record], bool]
) -> Row:
    """A share that should be large."""
    told = [(r.key, right(r)) for r in records]
    return _share(what, f">= {least:.0%}", told, lambda s: s >= least)


def at_most(
    what: str, most: float, records: Iterable[Record], wrong: Callable[[Record], bool]
) -> Row:
    """A share that should be small."""
    told = [(r.key, not wrong(r)) for r in records]
    return _share(what, f"<= {most:.0%}", told, lambda s: s <= most, of_failures=True)


def _share(
    what: str, goal: str, told: Sequence[tuple[str, bool]], good: Callable[[float], bool],
    *, of_failures: bool = False,
) -> Row:  # fmt: skip
    count = len(told)
    if not count:
        return Row(what, goal, "-", 0)
    hits = sum(ok != of_failures for _, ok in told)
    low, high = wilson(hits, count)
    share = hits / count
    return Row(
        what, goal, f"{share:.1%}", count, f"{low:.1%} - {high:.1%}", good(share),
        [key for key, ok in told if not ok],
    )  # fmt: skip


# ------------------------------------------------------------------------------ what is right


def clear(r: Record) -> bool:
    """Whether nothing else in the catalogue looks like it."""
    return r.nearest >= APART


def exactly(r: Record) -> bool:
    """The true effects and nothing else."""
    return set(r.said) == set(r.names) and len(r.said) == len(r.names) and r.unknown is None


def named_in_its_class(r: Record) -> bool:
    """One name: the true effect's, or that of one that looks like it."""
    same = {*r.names, *(n for n, distance in r.near.items() if distance < APART)}
    return len(r.said) == 1 and r.unknown is None and r.said[0] in same


def told_apart(r: Record) -> bool:
    """The true effect named, and no class."""
    return exactly(r) and r.verdict == "effect_named"


def right_after_further(r: Record) -> bool:
    """The true effect where both sessions can tell it from all others; else its class."""
    return told_apart(r) if clear(r) else named_in_its_class(r) and r.names[0] in r.reported


def ranked_first(r: Record) -> bool:
    """The true effect before all others of the catalogue."""
    return bool(r.ranking) and r.ranking[0][0] in r.names


def confidently_wrong(r: Record) -> bool:
    """A single name, no other in the reported set, surely, and not the truth."""
    alone = len(r.said) == 1 and len(r.reported) == 1 and r.unknown is None
    return alone and r.named[0].confidence > SURE and r.said[0] not in _may_be_named(r)


def _may_be_named(r: Record) -> tuple[str, ...]:
    return () if r.family in ("outside", "excluded") else r.names


def is_unknown(r: Record) -> bool:
    """Whether it was said that something is missing which no catalogue has."""
    return r.verdict == "unknown_effect"


def outside(r: Record, left: str = "left_tolerant") -> bool:
    """Whether it counts as something that the catalogue does not know."""
    shares: dict[str, float] = getattr(r, left)
    enough = min(shares.values(), default=1.0) > IMITATED
    return r.family in ("outside", "excluded") and r.d >= OUTSIDE_SEEN and enough


def judged_for_confidence(r: Record) -> bool:
    """All cases but those that something in the catalogue imitates."""
    return r.family not in ("outside", "excluded") or outside(r)


def means_right(r: Record) -> bool:
    """The name where it can be seen; where it cannot, to say so and name nothing."""
    if r.d >= SEEN:
        return exactly(r) if clear(r) else bool(r.reported & {*r.names}) or named_in_its_class(r)
    return not r.said and r.unknown is None and r.names[0] in r.invisible


def place_right(r: Record) -> bool:
    """The profile's peak on the right sheet and near the middle of the true place."""
    assert r.unknown is not None
    assert r.truth[0].place_mm is not None
    low, high = r.truth[0].place_mm
    along = r.unknown.along in ("s", "place") and r.unknown.configuration != "short"
    return along and abs(r.unknown.peak - 0.5 * (low + high)) <= WITHIN_MM


def has_place(r: Record) -> bool:
    """Whether it has a place of its own along the long sheet."""
    place = r.truth[0].place_mm
    return (
        place is not None and place[1] - place[0] < WIDEST_MM and r.names[0] != "clamp_compliance"
    )


# ------------------------------------------------------------------------------ the table


def scored(records: Sequence[Record]) -> list[Row]:
    """The table."""
    good = [r for r in records if not r.error.startswith("not made")]
    by = {name: [r for r in good if r.family == name] for name in {r.family for r in good}}

    def of(*families: str) -> list[Record]:
        return [r for f in families for r in by.get(f, [])]

    seen = [r for r in of("other_form") if r.d >= SEEN]
    own = [r for r in of("own_form") if r.d >= SEEN]
    nothing = of("nothing")
    realistic = [r for r in of("realistic") if _is_realistic(r) and clear(r)]
    means = [r for r in of("means_only") if r.d >= SEEN or r.d < NOT_SEEN]
    pairs = [r for r in of("pair") if r.d >= SEEN and clear(r)]
    further = [r for r in of("ambiguous") if r.further is not None]
    beyond = [r for r in of("outside", "excluded") if outside(r)]
    strict = [r for r in of("outside", "excluded") if outside(r, "left")]
    caught = [r for r in beyond if is_unknown(r) and r.unknown is not None]
    within = [r for r in of(*SINGLE, "pair") if r.d >= SEEN]
    answered = [r for r in good if not r.error]
    return [
        at_most("nothing hidden: an effect named", 0.02, nothing, lambda r: bool(r.said)),
        at_most("nothing hidden: 'unknown'", 0.05, nothing, is_unknown),
        at_least("other form, d >= 8: truth ranked first", 0.97,
                 [r for r in seen if clear(r)], ranked_first),
        at_least("the same, catalogue's form", 0.97, [r for r in own if clear(r)], ranked_first),
        at_least("other form, d >= 8: exactly the true effect named", 0.97,
                 [r for r in seen if clear(r)], exactly),
        at_least("the same, catalogue's form", 0.97, [r for r in own if clear(r)], exactly),
        at_least("one that looks like others: a name of its class", 0.97,
                 [r for r in [*seen, *own] if not clear(r)], named_in_its_class),
        at_least("other form, d >= 8: truth in the reported set", 0.99, seen,
                 lambda r: r.names[0] in r.reported),
        mean_at_most("the same: mean size of the set", 1.2,
                     [len(r.reported) for r in seen if r.reported]),
        mean_at_most("the same, nothing else within 4 sigma: mean size of the set", 1.2,
                     [len(r.reported) for r in seen if r.reported and clear(r)]),
        at_most("confidently wrong, all cases", 0.01,
                [r for r in answered if judged_for_confidence(r)], confidently_wrong),
        at_least("realistic gap, other form: exactly the true effect", 0.97, realistic, exactly),
        at_least("means only: right name, or 'cannot be seen'", 0.98, means, means_right),
        at_least("two effects, d 8 - 30: exactly both", 0.90, pairs, exactly),
        at_least("two effects: both among the named", 0.95, pairs,
                 lambda r: set(r.names) <= set(r.said)),
        at_least("ambiguous, after the recommended measurement: right", 0.99, further,
                 right_after_further),
        at_least("the same, where it leaves nothing else within 4 sigma", 0.99,
                 [r for r in further if clear(r)], told_apart),
        at_least("outside the catalogue, d >= 30: 'unknown'", 0.95, beyond, is_unknown),
        at_least("the same, imitations judged without tolerance", 0.95, strict, is_unknown),
        at_most("in the catalogue, d >= 8: 'unknown'", 0.05, within, is_unknown),
        at_least("the unknown's location", 0.97, caught,
                 lambda r: r.unknown is not None and r.unknown.slot in r.truth[0].accepted_slots),
        at_least("the unknown's place within 10 mm", 0.95, [r for r in caught if has_place(r)],
                 place_right),
        _closed("left-out gap closed, d 20 - 45, median", 0.95,
                [r for r in of(*SINGLE) if THIRTY[0] <= r.d <= THIRTY[1]]),
        _closed("left-out gap closed, realistic, median", 0.98, of("realistic")),
        coverage(of("own_form")),
        _times("analysis, CPU time", 10.0, [r.cpu_s for r in answered if r.family != "nulls"]),
        _times("with 500 nulls, wall time", 300.0, [r.seconds for r in of("nulls")]),
        at_most("refused or failed", 0.0, good, lambda r: bool(r.error)),
    ]  # fmt: skip


def _is_realistic(r: Record) -> bool:
    if r.d < SEEN:
        return False
    felt = REALISTIC_MN[0] <= r.force_gap_mN <= REALISTIC_MN[1]
    return felt or (r.force_gap_mN < 1e-6 and r.curve_gap_mm > 0.0)


def mean_at_most(what: str, most: float, values: Sequence[float]) -> Row:
    """A mean that should be small."""
    if not values:
        return Row(what, f"<= {most:g}", "-", 0)
    mean = float(np.mean(values))
    reach = Z90 * float(np.std(values)) / math.sqrt(len(values))
    interval = f"{mean - reach:.2f} - {mean + reach:.2f}"
    return Row(what, f"<= {most:g}", f"{mean:.2f}", len(values), interval, mean <= most)


def _closed(what: str, least: float, records: Sequence[Record]) -> Row:
    """Of cases that were named right and whose gap stands out; no number counts as not closed."""
    use = [
        r for r in records
        if exactly(r) and (r.chi2_before or 0.0) > STANDS_OUT
    ]  # fmt: skip
    goal = f">= {least:.0%}"
    if not use:
        return Row(what, goal, "-", 0)
    values = np.array([0.0 if r.closed is None else r.closed for r in use])
    low, high = np.quantile(values, [0.25, 0.75])
    median = float(np.median(values))
    bad = [r.key for r, v in zip(use, values, strict=True) if v < 0.5]
    return Row(what, goal, f"{median:.1%}", len(use), f"quartiles {low:.1%}, {high:.1%}",
               median >= least, bad)  # fmt: skip


def intervals(r: Record) -> list[tuple[str, bool]]:
    """Each true parameter of a rightly named effect, and whether its interval holds it."""
    if not (exactly(r) and len(r.truth) == 1 and r.truth[0].as_in_catalogue and r.d >= SEEN):
        return []
    result, truth = [], r.truth[0]
    for name, value in truth.parameters.items():
        found = r.named[0].parameters.get(name, {})
        for configuration, (_, low, high) in found.items():
            if configuration in ("", ON_ONE_SHEET.get(truth.effect, configuration)):
                result.append((f"{truth.effect}.{name}", low <= value <= high))
    return result


def coverage(records: Sequence[Record]) -> Row:
    """How often the 90 % interval of a parameter holds the truth."""
    told = [(r.key, ok) for r in records for _, ok in intervals(r)]
    return _share("90 % interval of a parameter holds the truth", "88 - 92 %", told,
                 lambda s: 0.88 <= s <= 0.92)  # fmt: skip


def _times(what: str, most_s: float, seconds: Sequence[float]) -> Row:
    goal = f"<= {most_s:g} s"
    if not seconds:
        return Row(what, goal, "-", 0)
    median, late = np.quantile(seconds, [0.5, 0.95])
    spread = f"95 % below {late:.1f} s, longest {max(seconds):.1f} s"
    return Row(what, goal, f"{median:.1f} s", len(seconds), spread, bool(late <= most_s))


# ------------------------------------------------------------------------------ as text


def table(rows: Sequence[Row]) -> str:
    """Markdown."""
    lines = ["| | goal | found | cases | 90 % interval | met |", "|---|---|---|---|---|---|"]
    for r in rows:
        met = {True: "yes", False: "**no**", None: ""}[r.met]
        lines.append(f"| {r.what} | {r.goal} | {r.value} | {r.count} | {r.interval} | {met} |")
    return "\n".join(lines)


def by_parameter(records: Sequence[Record]) -> str:
    """Coverage of each parameter."""
    told: dict[str, list[bool]] = {}
    for r in records:
        for name, ok in intervals(r):
            told.setdefault(name, []).append(ok)
    return "\n".join(f"  {n:45} {sum(v)}/{len(v)}" for n, v in sorted(told.items()))


def failures(rows: Sequence[Row], records: Sequence[Record]) -> str:
    """The cases that fail, each with what it is, what was said, and in which lines of the table."""
    lines: dict[str, list[str]] = {}
    for row in rows:
        for key in row.failed:
            lines.setdefault(key, []).append(row.what)
    by_key = {r.key: r for r in records}
    return "\n".join(_told(by_key[k], wanted) for k, wanted in sorted(lines.items()))


def _told(r: Record, wanted: Sequence[str]) -> str:
    truth = " + ".join(f"{t.effect}/{t.form} {t.size:.3g} (d {t.d:.0f})" for t in r.truth)
    near = min(r.near, key=r.near.__getitem__, default="")
    beside = f", next {near} at {r.near[near]:.1f}" if near else ""
    own = [r.left_tolerant[n] for n in r.names if n in r.left_tolerant]
    if own:  # a catalogue that cannot describe the truth is another fault than a wrong choice
        beside += f", its own entry leaves {max(own):.0%}"
    said = ", ".join(f"{n.name} {n.confidence:.2f}" for n in r.named) or "nothing"
    unknown = "" if r.unknown is None else f" + unknown {r.unknown.slot} at {r.unknown.peak:.0f}"
    if r.further is not None:
        then = ", ".join(r.further.reported)
        beside += f", after {r.further.extra} (before: {then}, next {r.further.nearest:.1f})"
    return (
        f"{r.key} [{r.conditions}] {truth or 'nothing'}{beside}: said {said}{unknown}"
        f" {r.error} <- {'; '.join(wanted)}"
    )
