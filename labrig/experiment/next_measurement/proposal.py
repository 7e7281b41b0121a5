"""Propose the measurement that separates two effects, stated or from a diagnosis."""

from __future__ import annotations

from labrig.errors import BadArgumentError
from model.discrepancy import DiagnoseOptions, Diagnosis, Next
from model.discrepancy.verdict.messages import OTHER_ANSWERS, shown_by
from model.effects import title
from model.measurements import Measurements

Pair = tuple[str, str]


def pair_of(found: Diagnosis) -> Pair | None:
    """Return two effects that the diagnosis could not tell apart; None: there are none.

    The first name with what it may be instead; else the two likeliest names of what is unknown, or
    of what is not ruled out.
    """
    for one in found.effects:
        if one.confusable_with:
            return one.name, one.confusable_with[0]
    for names in _possible(found):
        if len(names) > 1:
            return names[0], names[1]
    return None


def _possible(found: Diagnosis) -> tuple[list[str], list[str]]:
    """Return the names of what is unknown, and of what is not ruled out, the likeliest first."""
    of_unknown = () if found.unknown is None else found.unknown.confusable_with
    both = (of_unknown, tuple(found.not_ruled_out))
    first, second = ([name for name in some if name not in OTHER_ANSWERS] for some in both)
    return first, second


def no_pair(found: Diagnosis) -> str:
    """Return why a diagnosis names no two effects, and what shows the one that it may name."""
    of_unknown, _ = _possible(found)
    if found.verdict == "cannot_tell":
        return (
            f"the diagnosis names no effects. {found.sentence} To tell two effects apart all the "
            "same, name them with between, such as gravity and clamp_angle."
        )
    if not of_unknown:
        return (
            "the diagnosis names no two effects that could be mistaken for each other "
            f"({found.verdict.replace('_', ' ')}); name two with between, such as gravity and "
            "clamp_angle."
        )
    (name,) = of_unknown
    other = "gravity" if name != "gravity" else "clamp_angle"
    return (
        f"the diagnosis names {title(name)} alone, or something that is not in the catalogue, and "
        f"no measurement can be chosen to tell it from that. {shown_by([name])} To tell it from "
        f"another effect, name both with between, such as {name} and {other}."
    )


def proposal(
    measurements: Measurements,
    diagnosis: Diagnosis | None,
    between: Pair | None,
    options: DiagnoseOptions | None = None,
) -> Next:
    """Return the measurement that separates `between`; without it the diagnosis names them.

    What the diagnosis has proposed for the same two is the answer to either question.

    Raises BadArgumentError where nobody names two effects, ModelError where nothing separates them.
    """
    from model.discrepancy import next_measurement as find

    kept = None if diagnosis is None else diagnosis.next_measurement
    if between is not None and kept is not None and set(kept.between) == set(between):
        return kept
    if between is not None:
        return find(measurements, between, options)
    if diagnosis is None:
        raise BadArgumentError(
            "name two effects with between, such as gravity and clamp_angle, or run labrig "
            "diagnose first: its diagnosis names them.",
            "between",
        )
    if kept is not None:
        return kept
    pair = pair_of(diagnosis)
    if pair is None:
        raise BadArgumentError(no_pair(diagnosis), "between")
    return find(measurements, pair, options)
