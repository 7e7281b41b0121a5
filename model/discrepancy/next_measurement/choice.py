"""The measurement that separates effects best for the time it takes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from model.discrepancy.next_measurement.extended_design import extended
from model.discrepancy.next_measurement.menu import MENU, CandidateMeasurement
from model.discrepancy.next_measurement.separation import Suspect, distance, equally_long
from model.discrepancy.thresholds import COMPARISON_SIGMA, LEAST_GAIN_SIGMA
from model.discrepancy.verdict.messages import listed
from model.discrepancy.verdict.result import Next
from model.effects import title
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray, ModelError


@dataclass(frozen=True)
class _Choice:
    """An entry of the menu, with the separations of all pairs after it."""

    entry: CandidateMeasurement
    then: FloatArray  # (pairs,) sigmas
    minutes: float


def next_measurement(
    fitted: MixedModelFit, pairs: Sequence[Sequence[Suspect]], weights: Sequence[float] = (1.0,)
) -> Next | None:
    """Return the entry that separates pairs best for its time; None: there is none.

    All pairs have the same first effect; `weights` say how much each counts. The proposal is for
    the one that it separates further.
    """
    if not pairs:
        return None
    equal = [equally_long(fitted, pair) for pair in pairs]
    now, weight = np.array([distance(fitted, pair) for pair in equal]), np.array(weights)
    choices = list(_choices(fitted, equal))
    if not choices:
        return None

    def worth(one: _Choice) -> tuple[float, float]:
        separated = weight @ np.minimum(one.then, COMPARISON_SIGMA)
        gained = weight @ np.maximum(one.then**2 - now**2, 0.0)
        return float(separated), float(gained) / one.minutes

    best = max(choices, key=worth)
    further = np.minimum(best.then, COMPARISON_SIGMA) - np.minimum(now, COMPARISON_SIGMA)
    order = np.argsort(-weight * further, kind="stable").tolist()
    which, *others = order
    improved = [which, *(i for i in others if further[i] >= LEAST_GAIN_SIGMA)]
    first, names = equal[which][0].effect.name, [equal[i][1].effect.name for i in improved]
    return Next(
        why=f"{best.entry.what}, to separate {title(first)} from {listed([*map(title, names)])}",
        extra=best.entry.name,
        between=(first, names[0]),
        separation=float(now[which]),
        expected=float(best.then[which]),
        minutes=best.minutes,
        protocol=best.entry.protocol,
    )


def _choices(fitted: MixedModelFit, pairs: Sequence[tuple[Suspect, Suspect]]) -> Iterator[_Choice]:
    """Yield the entries of the menu whose designs have an answer."""
    for entry in MENU:
        try:
            more = extended(fitted, entry)
            then = np.array([distance(more, pair) for pair in pairs])
        except (ModelError, np.linalg.LinAlgError):
            continue
        minutes = sum(entry.minutes(one) for one in fitted.problem.forward.data_vectors)
        yield _Choice(entry, then, minutes)
