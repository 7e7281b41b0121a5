"""What the checks of an effect's structure share: it acts alike in all parts of the data."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import permutations

import numpy as np

from model.discrepancy.criticism.check_result import Consequence, Failure
from model.discrepancy.criticism.group_amplitudes import (
    Group,
    GroupAmplitude,
    group_amplitudes,
)
from model.discrepancy.criticism.named_model import NamedModel, limited_scatter
from model.discrepancy.search.form_share import in_time
from model.discrepancy.thresholds import (
    LEAST_GROUP_RATIO,
    LEAST_RIGID_RATIO,
    LEAST_TIMED_RATIO,
    STRUCTURE_SIGMA,
)
from model.effects import title
from model.effects.interface import Along, Effect

LEAST_WHOLE = 0.2  # of the named amplitude, that is in a group without doubt
ALONG_THE_SHEET = frozenset({"s", "curvature", "place"})


def contradicted(
    named: NamedModel,
    groups: Sequence[Group],
    applies: Callable[[Effect], bool] = lambda _: True,
    along: Along | None = None,
) -> Iterator[Failure]:
    """Yield a failure for each effect to which it applies that acts otherwise in another group.

    `along` is the coordinate that tells the groups apart, where a form may differ along it.
    """
    if len(groups) < 2:
        return
    log_sigma = limited_scatter(named.fitted)
    for index, one in enumerate(named.fitted.found):
        if one not in named.found or not applies(one.effect):
            continue
        every = group_amplitudes(named.fitted, index, groups, log_sigma)
        pair = _apart(every, least_ratio(one.effect, along))
        if pair is not None:
            weak, strong = pair
            yield Failure(
                consequence=Consequence.REJECT_UNLESS_PROBABLE,
                sentence=(
                    f"amplitude of {title(one.effect.name)}, relative to that in all data:"
                    f" {_number(strong)} {strong.title}, but {_number(weak)} {weak.title}"
                ),
                effects=(one.effect.name,),
            )


def _apart(
    every: Sequence[GroupAmplitude], least: float
) -> tuple[GroupAmplitude, GroupAmplitude] | None:
    """Return the weak and the strong group that contradict each other most; None: none do."""
    best, found = STRUCTURE_SIGMA, None
    for weak, strong in permutations(every, 2):
        gap = least * strong.factor - weak.factor
        sigma = float(np.hypot(weak.sigma, least * strong.sigma))
        there = strong.factor - STRUCTURE_SIGMA * strong.sigma > LEAST_WHOLE
        if there and gap > best * sigma:
            best, found = gap / sigma, (weak, strong)
    return found


def least_ratio(effect: Effect, along: Along | None) -> float:
    """Return the smallest ratio of amplitudes in two groups that the effect's form allows."""
    # readings, runs and sheets are at other times; the voltages take turns in each run
    slow = "session" in effect.form_error_along
    if in_time(effect) and not (slow and along == "voltage"):
        return LEAST_TIMED_RATIO
    rigid = has_one_weight(effect) and along not in effect.form_error_along
    return LEAST_RIGID_RATIO if rigid else LEAST_GROUP_RATIO


def has_one_weight(effect: Effect) -> bool:
    """Return whether forces and curves, and sheets of another length, see the same part of it.

    Of what is distributed along the sheet in a form of its own they do not.
    """
    return not ALONG_THE_SHEET.intersection(effect.form_error_along)


def _number(one: GroupAmplitude) -> str:
    return f"{one.factor:.2f} ± {one.sigma:.2f}"
