"""Which names of a verdict are too improbable to be reported."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence

from model.discrepancy.answers.calibrated_answers import Judged, is_name
from model.discrepancy.answers.choice_set import NOTHING, UNKNOWN
from model.discrepancy.thresholds import LEAST_PROBABILITY, PROBABLY_NOTHING
from model.discrepancy.verdict.posterior import Choice
from model.identification.likelihood.model_state import Found


def improbable(judged: Judged) -> bool:
    """Return whether a name is rather nothing, or something unknown.

    Where something is there for sure a name of less than one half may still be the likeliest.
    """
    names, unknown, nothing = (
        judged.of_names, judged.probabilities.get(UNKNOWN, 0.0),
        judged.probabilities.get(NOTHING, 0.0),
    )  # fmt: skip
    return names < LEAST_PROBABILITY and (names <= unknown or nothing >= PROBABLY_NOTHING)


def beside_strict_form(name: str, found: Sequence[Found]) -> bool:
    """Return whether a name was found only beside the catalogue's own form of an earlier one."""
    strict = [one.effect.name for one in found if one.form < 1.0]
    names = [one.effect.name for one in found]
    later = names[names.index(strict[0]) :] if strict else []
    return name in later and name not in strict


def maybe_absent(name: str, judged: Judged, found: Sequence[Found]) -> bool:
    """Return whether a name that an earlier one's form hides may as well be nothing."""
    return NOTHING in judged.answers and beside_strict_form(name, found)


def of_others(judged: Judged, taken: Collection[str]) -> float:
    """Return the probability that it is some effect of the catalogue besides these."""
    chances = judged.probabilities.items()
    return sum(p for name, p in chances if is_name(name) and name not in taken)


def pieces(named: Sequence[Choice]) -> list[str]:
    """Return names that share their location with another one, or are one of several loops.

    Several effects of one place may together imitate something that acts there. So may loops of the
    force, wherever they come from: two are one of another form.
    """
    count = Counter(one.effect.location for one in named)
    loops = sum(one.effect.by_history for one in named)
    return [
        one.effect.name for one in named
        if count[one.effect.location] > 1 or (one.effect.by_history and loops > 1)
    ]  # fmt: skip
