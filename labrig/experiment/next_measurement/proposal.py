"""Propose the measurement that separates two effects, stated or from a diagnosis."""

from __future__ import annotations

from labrig.errors import BadInputError
from model.discrepancy import DiagnoseOptions, Diagnosis, Next
from model.measurements import Measurements

Pair = tuple[str, str]


def pair_of(found: Diagnosis) -> Pair | None:
    """Return two effects that the diagnosis could not tell apart."""
    pairs = ((one.name, one.confusable_with[0]) for one in found.effects if one.confusable_with)
    return next(pairs, None)


def proposal(
    measurements: Measurements,
    diagnosis: Diagnosis | None,
    between: Pair | None,
    options: DiagnoseOptions | None = None,
) -> Next:
    """Return the measurement that separates `between`; without it the diagnosis names them.

    What the diagnosis has proposed for the same two is the answer to either question.

    Raises BadInputError where nobody names two effects, ModelError where nothing separates them.
    """
    from model.discrepancy import next_measurement as find

    kept = None if diagnosis is None else diagnosis.next_measurement
    if between is not None and kept is not None and set(kept.between) == set(between):
        return kept
    if between is not None:
        return find(measurements, between, options)
    if diagnosis is None:
        raise BadInputError(
            "name two effects with --between, such as --between gravity clamp_angle, or run "
            "labrig diagnose first: its diagnosis names them."
        )
    if kept is not None:
        return kept
    pair = pair_of(diagnosis)
    if pair is None:
        raise BadInputError(
            "the diagnosis names no two effects that could be mistaken for each other; name two "
            "with --between, such as --between gravity clamp_angle."
        )
    return find(measurements, pair, options)
