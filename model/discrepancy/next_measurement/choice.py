"""The measurement that separates two effects best for the time it takes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from model.discrepancy.next_measurement.extended_design import extended
from model.discrepancy.next_measurement.menu import MENU, CandidateMeasurement
from model.discrepancy.next_measurement.separation import Suspect, distance, equally_long
from model.discrepancy.thresholds import COMPARISON_SIGMA
from model.discrepancy.verdict.result import Next
from model.effects import title
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import ModelError


def next_measurement(fitted: MixedModelFit, between: Sequence[Suspect]) -> Next | None:
    """Return the entry that separates the first two best for its time; None: there is none."""
    if len(between) < 2:
        return None
    pair = equally_long(fitted, between[:2])
    now = distance(fitted, pair)
    best: tuple[float, CandidateMeasurement, float, float] | None = None
    for entry in MENU:
        try:
            then = distance(extended(fitted, entry), pair)
        except (ModelError, np.linalg.LinAlgError):
            continue
        minutes = sum(entry.minutes(one) for one in fitted.problem.forward.looks)
        worth = max(then**2 - now**2, 0.0) / minutes
        if best is None or (min(then, COMPARISON_SIGMA), worth) > (
            min(best[2], COMPARISON_SIGMA),
            best[0],
        ):
            best = (worth, entry, then, minutes)
    if best is None:
        return None
    _, entry, then, minutes = best
    names = tuple(one.effect.name for one in pair)
    return Next(
        why=f"{entry.what}, to separate {' from '.join(map(title, names))}",
        extra=entry.name,
        between=names,
        separation=now,
        expected=then,
        minutes=minutes,
        protocol=entry.protocol,
    )
